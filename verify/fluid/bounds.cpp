#include "verify/fluid/bounds.h"

#include <cmath>

#include "verify/compare.h"

namespace lockstep::verify {
namespace {

using namespace fluid;

// Calls visit(i, j, dx, dy, dz, r2) for every ordered pair of particles within h, i == j included.
template <class Visit>
void for_each_neighbour(const Fluid<double>& fluid, const Visit& visit) {
  const Grid<double>& grid = fluid.grid;
  const Vectors<double>& p = fluid.particles.position;
  for (int z = 0; z < grid.z.cells; ++z)
    for (int y = 0; y < grid.y.cells; ++y)
      for (int x = 0; x < grid.x.cells; ++x) {
        const Run own = row_run(grid, x, x, y, z);
        for (int i = own.begin; i < own.end; ++i)
          for (const Run& run : neighbour_runs(grid, x, y, z))
            for (int j = run.begin; j < run.end; ++j) {
              const double dx = p.x[i] - p.x[j], dy = p.y[i] - p.y[j], dz = p.z[i] - p.z[j];
              const double r2 = dx * dx + dy * dy + dz * dz;
              if (r2 < fluid.model.smoothing_length_2) visit(i, j, dx, dy, dz, r2);
            }
      }
}

// Calls visit(r2) for every point of a simple cubic lattice within h of the origin, which is one of them.
template <class Visit>
void for_each_lattice_point(const Model<double>& model, double spacing, const Visit& visit) {
  const int reach = static_cast<int>(model.smoothing_length / spacing);
  for (int z = -reach; z <= reach; ++z)
    for (int y = -reach; y <= reach; ++y)
      for (int x = -reach; x <= reach; ++x) {
        const double r2 = (x * x + y * y + z * z) * spacing * spacing;
        if (r2 < model.smoothing_length_2) visit(r2);
      }
}

}  // namespace

std::vector<double> density_rounding(const Fluid<double>& truth, std::span<const double> density) {
  std::vector<double> terms(truth.particles.count, 0), rounding(truth.particles.count);
  for_each_neighbour(truth, [&](int i, int, double, double, double, double) { terms[i] += 1; });
  for (std::size_t i = 0; i < rounding.size(); ++i) rounding[i] = terms[i] * unit_roundoff * density[i];
  return rounding;
}

Vectors<double> force_rounding(const Fluid<double>& truth, std::span<const double> density,
                               std::span<const double> density_error) {
  const Model<double>& model = truth.model;
  const Vectors<double>& v = truth.particles.velocity;
  const int count = truth.particles.count;
  std::vector<double> terms(count, 1);  // gravity
  Vectors<double> sum, by_density;
  sum.resize(count);
  by_density.resize(count);
  for (int i = 0; i < count; ++i)
    sum.x[i] = std::abs(model.gravity.x), sum.y[i] = std::abs(model.gravity.y), sum.z[i] = std::abs(model.gravity.z);
  for_each_neighbour(truth, [&](int i, int j, double dx, double dy, double dz, double r2) {
    if (i == j) return;
    terms[i] += 1;
    const double h = model.smoothing_length, distance = std::sqrt(std::max(r2, model.min_distance_2)),
                 overlap = h - distance;
    const double scale = overlap / (density[i] * density[j]);
    // Of the pressure in the sum of the densities.
    const double slope = model.pressure_coefficient * scale * overlap / distance;
    const double pressure = std::abs(slope * (density[i] + density[j] - model.twice_rest_density));
    const double viscosity = model.viscosity_coefficient * scale;
    const double relative = density_error[i] / density[i] + density_error[j] / density[j];
    const double error = slope * (density_error[i] + density_error[j]);
    const auto add = [&](Array<double>& to, Array<double>& through_density, double d, double dv) {
      to[i] += std::abs(d) * pressure + std::abs(dv) * viscosity;
      through_density[i] += std::abs(d) * (pressure * relative + error) + std::abs(dv) * viscosity * relative;
    };
    add(sum.x, by_density.x, dx, v.x[j] - v.x[i]);
    add(sum.y, by_density.y, dy, v.y[j] - v.y[i]);
    add(sum.z, by_density.z, dz, v.z[j] - v.z[i]);
  });
  for (int i = 0; i < count; ++i) {
    const double factor = terms[i] * unit_roundoff;
    sum.x[i] = factor * sum.x[i] + by_density.x[i];
    sum.y[i] = factor * sum.y[i] + by_density.y[i];
    sum.z[i] = factor * sum.z[i] + by_density.z[i];
  }
  return sum;
}

double lattice_density(const Model<double>& model, double spacing) {
  double sum = 0;
  for_each_lattice_point(model, spacing, [&](double r2) { sum += std::pow(model.smoothing_length_2 - r2, 3); });
  return model.density_coefficient * sum;
}

double lattice_density_rounding(const Model<double>& model, double spacing, double reach) {
  // A coordinate is off by u reach, a difference of two by twice that, r^2 by 2 r times sqrt(3) times that; in float
  // r^2 and h^2 - r^2 round by at most 4 u h^2 more. What that does to a term t^3 is 3 t^2 times it.
  double through_positions = 0, terms = 0;
  for_each_lattice_point(model, spacing, [&](double r2) {
    const double t = model.smoothing_length_2 - r2;
    const double error =
        2 * std::sqrt(r2) * std::sqrt(3.) * 2 * unit_roundoff * reach + 4 * unit_roundoff * model.smoothing_length_2;
    through_positions += 3 * t * t * error;
    terms += 1;
  });
  return model.density_coefficient * through_positions + (terms + 3) * unit_roundoff * lattice_density(model, spacing);
}

}  // namespace lockstep::verify
