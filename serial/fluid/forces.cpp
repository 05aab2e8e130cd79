// The acceleration of every particle by pressure and viscosity of its neighbours within h, and by gravity.
//
// Symmetric: every pair is met once (see densities.cpp); what it gives to one particle it takes from the other.
// Owner-gather: every particle meets all its neighbours, in the list that the densities left, and sums for itself: twice the
// terms.
// Pair lists: symmetric over the pairs that the densities noted.
//
// Source: [Mueller 2003]; [LRB08] Figure 9. The contract with the equation stands in common/fluid/forces.h.
#include "common/fluid/forces.h"

#include <algorithm>

#include "common/real.h"

namespace lockstep::fluid::serial {
namespace {

// What neighbour j does to particle i, r2 = |p_i - p_j|^2 < h^2.
Vector3<Real> pair_acceleration(const Model<Real>& model, const Particles<Real>& particles, std::span<const Real> density, int i, int j,
                                Real dx, Real dy, Real dz, Real r2) {
  const Vectors<Real>& v = particles.velocity;
  const Real distance = sqrt(max(r2, model.min_distance_2));
  const Real overlap = model.smoothing_length - distance;
  const Real scale = overlap / (density[i] * density[j] * distance);  // the one division
  const Real pressure = model.pressure_coefficient * scale * overlap * (density[i] + density[j] - model.twice_rest_density);
  const Real viscosity = model.viscosity_coefficient * scale * distance;
  return {dx * pressure + (v.x[j] - v.x[i]) * viscosity,  //
          dy * pressure + (v.y[j] - v.y[i]) * viscosity,  //
          dz * pressure + (v.z[j] - v.z[i]) * viscosity};
}

}  // namespace

void forces_symmetric(const Model<Real>& model, const Grid<Real>& grid, const Particles<Real>& particles, Neighbours<Real>&,
                      std::span<const Real> density, Vectors<Real>& acceleration) {
  const Real h2 = model.smoothing_length_2;
  const Vectors<Real>& p = particles.position;
  std::fill(acceleration.x.begin(), acceleration.x.end(), model.gravity.x);
  std::fill(acceleration.y.begin(), acceleration.y.end(), model.gravity.y);
  std::fill(acceleration.z.begin(), acceleration.z.end(), model.gravity.z);

  for (int z = 0; z < grid.z.cells; ++z)
    for (int y = 0; y < grid.y.cells; ++y)
      for (int x = 0; x < grid.x.cells; ++x) {
        const Run own = row_run(grid, x, x, y, z);
        const Runs forward = forward_runs(grid, x, y, z);
        for (int i = own.begin; i < own.end; ++i) {
          Vector3<Real> sum = {acceleration.x[i], acceleration.y[i], acceleration.z[i]};
          for (const Run& run : forward)
            for (int j = std::max(run.begin, i + 1); j < run.end; ++j) {
              const Real dx = p.x[i] - p.x[j], dy = p.y[i] - p.y[j], dz = p.z[i] - p.z[j];
              const Real r2 = dx * dx + dy * dy + dz * dz;
              if (r2 < h2) {
                const Vector3<Real> a = pair_acceleration(model, particles, density, i, j, dx, dy, dz, r2);
                sum.x += a.x, sum.y += a.y, sum.z += a.z;
                acceleration.x[j] -= a.x, acceleration.y[j] -= a.y, acceleration.z[j] -= a.z;
              }
            }
          acceleration.x[i] = sum.x, acceleration.y[i] = sum.y, acceleration.z[i] = sum.z;
        }
      }
}

void forces_owner_gather(const Model<Real>& model, const Grid<Real>& grid, const Particles<Real>& particles, Neighbours<Real>& neighbours,
                         std::span<const Real> density, Vectors<Real>& acceleration) {
  const Vectors<Real>& p = particles.position;
  const int rows = grid.y.cells * grid.z.cells;

  for (int row = 0; row < rows; ++row) {
    const Run own = row_run(grid, 0, grid.x.cells - 1, row % grid.y.cells, row / grid.y.cells);
    const Array<std::int32_t>& list = neighbours.row[row];
    int k = 0;
    for (int i = own.begin; i < own.end; ++i) {
      Vector3<Real> sum = {0, 0, 0};
      for (; k < neighbours.end[i]; ++k) {
        const int j = list[k];
        const Real dx = p.x[i] - p.x[j], dy = p.y[i] - p.y[j], dz = p.z[i] - p.z[j];
        const Real r2 = dx * dx + dy * dy + dz * dz;
        const Vector3<Real> a = pair_acceleration(model, particles, density, i, j, dx, dy, dz, r2);
        sum.x += a.x, sum.y += a.y, sum.z += a.z;
      }
      acceleration.x[i] = model.gravity.x + sum.x, acceleration.y[i] = model.gravity.y + sum.y, acceleration.z[i] = model.gravity.z + sum.z;
    }
  }
}

void forces_pair_lists(const Model<Real>& model, const Grid<Real>& grid, const Particles<Real>& particles, Neighbours<Real>& neighbours,
                       std::span<const Real> density, Vectors<Real>& acceleration) {
  const Vectors<Real>& p = particles.position;
  std::fill(acceleration.x.begin(), acceleration.x.end(), model.gravity.x);
  std::fill(acceleration.y.begin(), acceleration.y.end(), model.gravity.y);
  std::fill(acceleration.z.begin(), acceleration.z.end(), model.gravity.z);

  for (int z = 0; z < grid.z.cells; ++z) {
    const Run own = plane_run(grid, z, z);
    const Array<std::int32_t>& list = neighbours.plane[z];
    int k = 0;
    for (int i = own.begin; i < own.end; ++i) {
      Vector3<Real> sum = {acceleration.x[i], acceleration.y[i], acceleration.z[i]};
      for (; k < neighbours.end[i]; ++k) {
        const int j = list[k];
        const Real dx = p.x[i] - p.x[j], dy = p.y[i] - p.y[j], dz = p.z[i] - p.z[j];
        const Vector3<Real> a = pair_acceleration(model, particles, density, i, j, dx, dy, dz, neighbours.distance_2[z][k]);
        sum.x += a.x, sum.y += a.y, sum.z += a.z;
        acceleration.x[j] -= a.x, acceleration.y[j] -= a.y, acceleration.z[j] -= a.z;
      }
      acceleration.x[i] = sum.x, acceleration.y[i] = sum.y, acceleration.z[i] = sum.z;
    }
  }
}

}  // namespace lockstep::fluid::serial
