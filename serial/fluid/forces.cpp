// The acceleration of every particle by pressure and viscosity of its neighbours within h, and by gravity.
//
// Symmetric: every pair is met once (densities.cpp); its term is added to one particle and subtracted from the other.
// Owner-gather: every particle sums over its own list of neighbours, which the densities left: twice the terms.
// Pair lists: symmetric over the densities' lists of pairs.
//
// Source: [Mueller 2003]; [LRB08] Figure 9. The contract with the equation stands in common/fluid/forces.h.
#include "common/fluid/forces.h"

#include <algorithm>

#include "common/fluid/pair.h"
#include "common/real.h"

namespace lockstep::fluid::serial {

void forces_symmetric(const Model<Real>& model, const Grid<Real>& grid, const Particles<Real>& particles,
                      Neighbours<Real>&, std::span<const Real> density, Vectors<Real>& acceleration) {
  const Real h2 = model.smoothing_length_2;
  const Vectors<Real>&p = particles.position, &v = particles.velocity;
  std::fill(acceleration.x.begin(), acceleration.x.end(), model.gravity.x);
  std::fill(acceleration.y.begin(), acceleration.y.end(), model.gravity.y);
  std::fill(acceleration.z.begin(), acceleration.z.end(), model.gravity.z);

  for (int z = 0; z < grid.z.cells; ++z)
    for (int y = 0; y < grid.y.cells; ++y)
      for (int x = 0; x < grid.x.cells; ++x) {
        const Run own = row_run(grid, x, x, y, z);
        const Runs forward = forward_runs(grid, x, y, z);
        for (int i = own.begin; i < own.end; ++i) {
          const Vector3<Real> p_i = at(p, i);
          Vector3<Real> sum = at(acceleration, i);
          for (const Run& run : forward)
            for (int j = std::max(run.begin, i + 1); j < run.end; ++j) {
              const Vector3<Real> dp = p_i - at(p, j);
              const Real r2 = dot(dp, dp);
              if (r2 < h2) {
                const Vector3<Real> a = pair_acceleration(model, density[i], density[j], dp, at(v, j) - at(v, i), r2);
                sum = sum + a;
                put(acceleration, j, at(acceleration, j) - a);
              }
            }
          put(acceleration, i, sum);
        }
      }
}

void forces_owner_gather(const Model<Real>& model, const Grid<Real>& grid, const Particles<Real>& particles,
                         Neighbours<Real>& neighbours, std::span<const Real> density, Vectors<Real>& acceleration) {
  const Vectors<Real>&p = particles.position, &v = particles.velocity;
  const int rows = grid.y.cells * grid.z.cells;

  for (int row = 0; row < rows; ++row) {
    const Run own = row_run(grid, 0, grid.x.cells - 1, row % grid.y.cells, row / grid.y.cells);
    const Array<std::int32_t>& list = neighbours.row[row];
    int k = 0;
    for (int i = own.begin; i < own.end; ++i) {
      Vector3<Real> sum = {0, 0, 0};
      for (; k < neighbours.end[i]; ++k) {
        const int j = list[k];
        const Vector3<Real> dp = at(p, i) - at(p, j);
        const Vector3<Real> a = pair_acceleration(model, density[i], density[j], dp, at(v, j) - at(v, i), dot(dp, dp));
        sum = sum + a;
      }
      put(acceleration, i, model.gravity + sum);
    }
  }
}

void forces_pair_lists(const Model<Real>& model, const Grid<Real>& grid, const Particles<Real>& particles,
                       Neighbours<Real>& neighbours, std::span<const Real> density, Vectors<Real>& acceleration) {
  const Vectors<Real>&p = particles.position, &v = particles.velocity;
  std::fill(acceleration.x.begin(), acceleration.x.end(), model.gravity.x);
  std::fill(acceleration.y.begin(), acceleration.y.end(), model.gravity.y);
  std::fill(acceleration.z.begin(), acceleration.z.end(), model.gravity.z);

  for (int z = 0; z < grid.z.cells; ++z) {
    const Run own = plane_run(grid, z, z);
    const Array<std::int32_t>& list = neighbours.plane[z];
    int k = 0;
    for (int i = own.begin; i < own.end; ++i) {
      Vector3<Real> sum = at(acceleration, i);
      for (; k < neighbours.end[i]; ++k) {
        const int j = list[k];
        const Vector3<Real> dp = at(p, i) - at(p, j);
        const Vector3<Real> a =
            pair_acceleration(model, density[i], density[j], dp, at(v, j) - at(v, i), neighbours.distance_2[z][k]);
        sum = sum + a;
        put(acceleration, j, at(acceleration, j) - a);
      }
      put(acceleration, i, sum);
    }
  }
}

}  // namespace lockstep::fluid::serial
