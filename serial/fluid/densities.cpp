// The density at every particle, from the poly6 kernel over its neighbours within h.
//
// Symmetric: every pair is met once, and its term goes to both particles. A cell is tested against itself and the half
// of its neighbours that follow it in cell order (forward_runs), so no pair is met twice. This is what both papers
// parallelise.
//
// Owner-gather: every particle tests all 27 cells and sums for itself. Twice the distance tests, but each particle is
// written by its owner alone, so openmp/ needs no locks. The neighbours found go to lists, so that the forces need no
// search.
//
// Pair lists: symmetric, and the pairs found go to lists with their distances, so that the forces need no search
// either.
//
// About 15 % of the pairs tested lie within h: a sphere of radius h fills that much of 27 cells of edge h.
//
// Source: [Mueller 2003]; [LRB08] Figure 9. The contract stands in common/fluid/densities.h.
#include "common/fluid/densities.h"

#include <algorithm>

#include "common/fluid/pair.h"
#include "common/real.h"

namespace lockstep::fluid::serial {

void densities_symmetric(const Model<Real>& model, const Grid<Real>& grid, const Particles<Real>& particles,
                         Neighbours<Real>&, std::span<Real> density) {
  const Real h2 = model.smoothing_length_2;
  const Vectors<Real>& p = particles.position;
  std::fill(density.begin(), density.end(), density_term(h2, Real(0)));  // each particle's own term

  for (int z = 0; z < grid.z.cells; ++z)
    for (int y = 0; y < grid.y.cells; ++y)
      for (int x = 0; x < grid.x.cells; ++x) {
        const Run own = row_run(grid, x, x, y, z);
        const Runs forward = forward_runs(grid, x, y, z);
        for (int i = own.begin; i < own.end; ++i) {
          Real sum = density[i];
          for (const Run& run : forward)
            for (int j = std::max(run.begin, i + 1); j < run.end; ++j) {
              const Vector3<Real> dp = at(p, i) - at(p, j);
              const Real r2 = dot(dp, dp);
              if (r2 < h2) {
                const Real term = density_term(h2, r2);
                sum += term;
                density[j] += term;
              }
            }
          density[i] = sum;
        }
      }

  for (int i = 0; i < particles.count; ++i) density[i] = density_of(model, density[i]);
}

void densities_owner_gather(const Model<Real>& model, const Grid<Real>& grid, const Particles<Real>& particles,
                            Neighbours<Real>& neighbours, std::span<Real> density) {
  const Real h2 = model.smoothing_length_2;
  const Vectors<Real>& p = particles.position;
  const int rows = grid.y.cells * grid.z.cells;
  require_lists_fit(grid);

  for (int row = 0; row < rows; ++row) {
    const int y = row % grid.y.cells, z = row / grid.y.cells;
    Array<std::int32_t>& list = neighbours.row[row];
    list.clear();
    for (int x = 0; x < grid.x.cells; ++x) {
      const Run own = row_run(grid, x, x, y, z);
      const Runs candidates = neighbour_runs(grid, x, y, z);
      for (int i = own.begin; i < own.end; ++i) {
        Real sum = density_term(h2, Real(0));  // the particle's own term
        for (const Run& run : candidates)
          for (int j = run.begin; j < run.end; ++j) {
            const Vector3<Real> dp = at(p, i) - at(p, j);
            const Real r2 = dot(dp, dp);
            if (r2 < h2 && j != i) {
              sum += density_term(h2, r2);
              list.push_back(j);
            }
          }
        neighbours.end[i] = static_cast<std::int32_t>(list.size());
        density[i] = density_of(model, sum);
      }
    }
    pad(list);
  }
}

void densities_pair_lists(const Model<Real>& model, const Grid<Real>& grid, const Particles<Real>& particles,
                          Neighbours<Real>& neighbours, std::span<Real> density) {
  const Real h2 = model.smoothing_length_2;
  const Vectors<Real>& p = particles.position;
  require_lists_fit(grid);
  std::fill(density.begin(), density.end(), density_term(h2, Real(0)));  // each particle's own term

  for (int z = 0; z < grid.z.cells; ++z) {
    Array<std::int32_t>& list = neighbours.plane[z];
    Array<Real>& distance_2 = neighbours.distance_2[z];
    list.clear();
    distance_2.clear();
    for (int y = 0; y < grid.y.cells; ++y)
      for (int x = 0; x < grid.x.cells; ++x) {
        const Run own = row_run(grid, x, x, y, z);
        const Runs forward = forward_runs(grid, x, y, z);
        for (int i = own.begin; i < own.end; ++i) {
          Real sum = density[i];
          for (const Run& run : forward)
            for (int j = std::max(run.begin, i + 1); j < run.end; ++j) {
              const Vector3<Real> dp = at(p, i) - at(p, j);
              const Real r2 = dot(dp, dp);
              if (r2 < h2) {
                const Real term = density_term(h2, r2);
                sum += term;
                density[j] += term;
                list.push_back(j);
                distance_2.push_back(r2);
              }
            }
          neighbours.end[i] = static_cast<std::int32_t>(list.size());
          density[i] = sum;
        }
      }
    pad(list);
    pad(distance_2);
  }

  for (int i = 0; i < particles.count; ++i) density[i] = density_of(model, density[i]);
}

}  // namespace lockstep::fluid::serial
