// The density at every particle, from the poly6 kernel over its neighbours within h.
//
// Symmetric, under locks: every pair is met once, and its term goes to both particles, as in serial/. Sixteen neighbours j
// of one particle i are tested at once; they are different particles that stand side by side, so their densities are
// updated by one masked load, add and store. The grid is cut into one sub-grid a thread (sub_grids.h), and a cell that two
// threads may update is updated under its lock, taken once for all pairs of two cells. The order in which threads come to
// a shared cell changes the rounding: these forms alone depend on timing.
//
// Owner-gather: every particle looks at all 27 cells and sums for itself. The candidates of a cell are packed once, side by
// side, so that all particles of the cell test full vectors of them. No lock, and the same bits at every thread count.
//
// About 15 % of the pairs tested lie within h; the rest are lanes that add zero. notes/fluid.md says what that costs.
//
// Source: [Mueller 2003]; [LRB08] Figure 9. The contract stands in common/fluid/densities.h.
#include "common/fluid/densities.h"

#include <algorithm>

#include "common/real.h"
#include "common/simd.h"
#include "openmp/fluid/candidates.h"
#include "openmp/fluid/sub_grids.h"

namespace lockstep::fluid::openmp {
namespace {

using namespace lockstep::openmp;

void densities_symmetric(const Model<Real>& model, const Grid<Real>& grid, const Particles<Real>& particles, std::span<Real> density,
                         const SubGrids& sub_grids) {
  const Real h2 = model.smoothing_length_2;
  const Vectors<Real>& p = particles.position;
  Locks locks(grid.cells());

#pragma omp parallel
  {
    // Every element is one thread's; the loop's barrier ends it before any pair is added.
#pragma omp for simd schedule(static)
    for (int i = 0; i < particles.count; ++i) density[i] = h2 * h2 * h2;  // each particle's own term

    std::vector<floatv> sum;
    // Threads share no particle of a private cell; a shared cell's densities are read and written under its lock only.
#pragma omp for schedule(static, 1)
    for (const SubGrid& sub_grid : sub_grids.sub_grid)
      for (int z = sub_grid.z.begin; z < sub_grid.z.end; ++z)
        for (int y = sub_grid.y.begin; y < sub_grid.y.end; ++y)
          for (int x = sub_grid.x.begin; x < sub_grid.x.end; ++x) {
            const Run own = row_run(grid, x, x, y, z);
            if (own.begin == own.end) continue;
            sum.assign(own.end - own.begin, 0.f);
            forward_pieces(grid, sub_grids, x, y, z, [&](const Piece& piece) {
              const Guard guard(locks, piece.lock);
              for (int i = own.begin; i < own.end; ++i)
                for (int j = std::max(piece.run.begin, i + 1); j < piece.run.end; j += lanes) {
                  const maskv inside = first_lanes(piece.run.end - j);
                  const floatv dx = p.x[i] - load(&p.x[j]), dy = p.y[i] - load(&p.y[j]), dz = p.z[i] - load(&p.z[j]);
                  const floatv r2 = dx * dx + dy * dy + dz * dz;
                  const maskv near = inside & (r2 < h2);
                  const floatv t = select(near, h2 - r2, 0.f);
                  sum[i - own.begin] += t * t * t;
                  store(&density[j], load(&density[j], inside) + t * t * t, inside);
                }
            });
            const int cell = grid.cell(x, y, z);
            const Guard guard(locks, sub_grids.shared[cell] ? cell : Piece::no_lock);
            for (int i = own.begin; i < own.end; ++i) density[i] += reduce_add(sum[i - own.begin]);
          }

#pragma omp for simd schedule(static)
    for (int i = 0; i < particles.count; ++i) density[i] *= model.density_coefficient;
  }
}

}  // namespace

void densities_cell_locks(const Model<Real>& model, const Grid<Real>& grid, const Particles<Real>& particles, std::span<Real> density) {
  densities_symmetric(model, grid, particles, density, make_cell_locks(grid, omp_get_max_threads()));
}

void densities_sub_grid(const Model<Real>& model, const Grid<Real>& grid, const Particles<Real>& particles, std::span<Real> density) {
  densities_symmetric(model, grid, particles, density, make_sub_grids(grid, omp_get_max_threads()));
}

void densities_owner_gather(const Model<Real>& model, const Grid<Real>& grid, const Particles<Real>& particles, std::span<Real> density) {
  const Real h2 = model.smoothing_length_2;
  const Vectors<Real>& p = particles.position;
  const int rows = grid.y.cells * grid.z.cells;

#pragma omp parallel
  {
    Candidates<3> candidates;
    const auto& [cx, cy, cz] = candidates.field;
    // A cell writes the densities of its own particles alone. Rows of cells differ in work, hence dynamic.
#pragma omp for schedule(dynamic, 4)
    for (int row = 0; row < rows; ++row)
      for (int x = 0; x < grid.x.cells; ++x) {
        const int y = row % grid.y.cells, z = row / grid.y.cells;
        const Run own = row_run(grid, x, x, y, z);
        if (own.begin == own.end) continue;
        candidates.pack(neighbour_runs(grid, x, y, z), {p.x.data(), p.y.data(), p.z.data()}, {far_away, far_away, far_away});
        for (int i = own.begin; i < own.end; ++i) {
          floatv sum = 0;
          for (int j = 0; j < candidates.count; j += lanes) {  // i itself adds its own term, h^6
            const floatv dx = p.x[i] - load(&cx[j]), dy = p.y[i] - load(&cy[j]), dz = p.z[i] - load(&cz[j]);
            const floatv r2 = dx * dx + dy * dy + dz * dz;
            const floatv t = max(h2 - r2, 0.f);  // beyond h: nothing
            sum += t * t * t;
          }
          density[i] = model.density_coefficient * reduce_add(sum);
        }
      }
  }
}

}  // namespace lockstep::fluid::openmp
