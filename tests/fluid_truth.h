// The truth of the game fluid's densities and forces: sums over all pairs in double, of the float numbers widened, and
// how far a float sum may be from it.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "tests/fluid_states.h"

namespace lockstep::fluid {

struct TrueDensities {
  std::vector<double> value, bound;
};

// The bound: a difference of coordinates rounds once and r^2 five times more, so that t = h^2 - r^2 is off by less than
// 8 u h^2, also where that takes r across h; t^3 by 3 t^2 times that and its own roundings; the sum of n terms by n u.
inline TrueDensities true_densities(const Model<float>& model, const Particles<float>& p) {
  const double h2 = model.smoothing_length_2, t_error = 8 * u * h2;
  TrueDensities densities;
  for (int i = 0; i < p.count; ++i) {
    double sum = 0, error = 0, terms = 0;
    for (int j = 0; j < p.count; ++j) {
      const Vec a = vec_at(p.position, i), b = vec_at(p.position, j);
      const double r2 = (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]);
      if (!(r2 < h2 + t_error)) continue;
      const double t = std::max(h2 - r2, 0.);
      sum += t * t * t;
      error += std::pow(t + t_error, 3) - t * t * t + 4 * u * t * t * t;
      terms += 1;
    }
    densities.value.push_back(model.density_coefficient * sum);
    densities.bound.push_back(model.density_coefficient * (error + (terms + 4) * u * sum));
  }
  return densities;
}

struct Accelerations {
  std::vector<Vec> value, bound;
};

// The bound: distance and h - distance round, and the latter cancels, so that overlap is off by less than 8 u h; the
// sum of the densities less twice that at rest cancels likewise; the other factors round some sixteen times; the sum of
// n terms by n u.
inline Accelerations true_accelerations(const Model<float>& model, const Particles<float>& p,
                                        std::span<const float> density) {
  const double h = model.smoothing_length, h2 = model.smoothing_length_2, overlap_error = 8 * u * h;
  Accelerations accelerations;
  for (int i = 0; i < p.count; ++i) {
    Vec sum = vec(model.gravity), error = {0, 0, 0}, size = {std::abs(sum[0]), std::abs(sum[1]), std::abs(sum[2])};
    double terms = 1;
    for (int j = 0; j < p.count; ++j) {
      const Vec a = vec_at(p.position, i), b = vec_at(p.position, j), va = vec_at(p.velocity, i),
                vb = vec_at(p.velocity, j);
      const Vec d = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
      const double r2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
      if (i == j || !(r2 < h2 * (1 + 16 * u))) continue;
      const double distance = std::sqrt(std::max<double>(r2, model.min_distance_2)),
                   overlap = std::max(h - distance, 0.);
      const double rho = double(density[i]) * density[j], total = double(density[i]) + density[j];
      const double pressure = model.pressure_coefficient / distance * (total - model.twice_rest_density) / rho;
      const double viscosity = model.viscosity_coefficient / rho;
      const double cancelled = 2 * u * model.pressure_coefficient / distance * (total + model.twice_rest_density) / rho;
      const double overlap2_error = (overlap + overlap_error) * (overlap + overlap_error) - overlap * overlap;
      terms += 1;
      for (int k = 0; k < 3; ++k) {
        const double dv = vb[k] - va[k];
        const double by_pressure = d[k] * pressure * overlap * overlap, by_viscosity = dv * viscosity * overlap;
        sum[k] += by_pressure + by_viscosity;
        size[k] += std::abs(by_pressure) + std::abs(by_viscosity);
        error[k] += std::abs(d[k]) * (std::abs(pressure) * overlap2_error +
                                      cancelled * (overlap + overlap_error) * (overlap + overlap_error)) +
                    std::abs(dv) * viscosity * overlap_error;
      }
    }
    accelerations.value.push_back(sum);
    for (int k = 0; k < 3; ++k) error[k] += (terms + 16) * u * size[k];
    accelerations.bound.push_back(error);
  }
  return accelerations;
}

// How much of its bound the worst particle uses, over all calls.
struct Worst {
  double density = 0, acceleration = 0;
};

// Densities and forces of one form from the state, against the truth.
inline void check_kernels(const Form& form, Fluid<float> f, Worst& worst) {
  find_densities(form, f);
  const int count = f.particles.count;
  const std::span<const float> density(f.density.data(), count);
  const TrueDensities densities = true_densities(f.model, f.particles);
  for (int i = 0; i < count; ++i) {
    const double error = std::abs(density[i] - densities.value[i]);
    worst.density = std::max(worst.density, error / densities.bound[i]);
    ASSERT_LE(error, densities.bound[i]) << "density of particle " << f.particles.id[i] << ": " << density[i]
                                         << ", expected " << densities.value[i];
  }
  find_forces(form, f);
  const Accelerations accelerations = true_accelerations(f.model, f.particles, density);
  for (int i = 0; i < count; ++i)
    for (int k = 0; k < 3; ++k) {
      const double a = vec_at(f.acceleration, i)[k], error = std::abs(a - accelerations.value[i][k]);
      // Without gravity and neighbours the bound is zero, and so must the error be.
      if (error > 0) worst.acceleration = std::max(worst.acceleration, error / accelerations.bound[i][k]);
      ASSERT_LE(error, accelerations.bound[i][k]) << "acceleration "
                                                  << "xyz"[k] << " of particle " << f.particles.id[i] << ": " << a
                                                  << ", expected " << accelerations.value[i][k];
    }
}

}  // namespace lockstep::fluid
