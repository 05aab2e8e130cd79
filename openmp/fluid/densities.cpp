// The density at every particle, from the poly6 kernel over its neighbours within h.
//
// Symmetric, under locks: every pair is met once, and its term goes to both particles, as in serial/. Sixteen
// neighbours j of one particle i are tested at once; they are different particles that stand side by side, so their
// densities are updated by one masked load, add and store. The grid is cut into one sub-grid a thread (sub_grids.h),
// and a cell that two threads may update is updated under its lock, taken once for all pairs of two cells. The order in
// which threads reach a shared cell changes the rounding: only these forms depend on timing.
//
// Owner-gather: every particle tests the candidates of all 27 cells and sums for itself. The candidates of a cell,
// those within h of the box around its particles, are packed once, side by side, so that all particles of the cell test
// full vectors of them. No lock, and the same bits at every thread count. The neighbours found are compressed into
// lists, so that the forces need no search and work on full vectors.
//
// Pair lists: every pair is met once, without locks. The pairs of the particles of plane z of cells with what follows
// them in cell order reach planes z and z + 1 only, and the particles of both stand side by side. The thread of plane z
// sums in its own scratch for these two planes. The sums of plane z go to one array, those of plane z + 1 to another,
// `reaction`:
//
//     plane z - 1    own z - 1   reaction z                   So every element of both arrays is written once,
//     plane z                    own z       reaction z + 1   and a particle's total is own + reaction.
//
// The scratch of two planes fits a core's own cache. The same bits at every thread count. Candidates are packed as for
// owner-gather, but once for a block of two cells: that halves the packing, which costs as much as the tests, and adds
// few candidates.
//
// A ball of radius h fills 15 % of 27 cells of side h, so most pairs of particles there are farther apart than h. Those
// that are tested add zero. notes/fluid.md says what that costs.
//
// Source: [Mueller 2003]; [LRB08] Figure 9. The contract stands in common/fluid/densities.h.
#include "common/fluid/densities.h"

#include <algorithm>

#include "common/fluid/pair.h"
#include "common/real.h"
#include "common/simd.h"
#include "openmp/failure.h"
#include "openmp/fluid/candidates.h"
#include "openmp/fluid/lanes.h"
#include "openmp/fluid/lists_fit.h"
#include "openmp/fluid/sub_grids.h"
#include "openmp/vector_lanes.h"

namespace lockstep::fluid::openmp {
namespace {

using namespace lockstep::openmp;

void densities_symmetric(const Model<Real>& model, const Grid<Real>& grid, const Particles<Real>& particles,
                         std::span<Real> density, const SubGrids& sub_grids) {
  const Real h2 = model.smoothing_length_2;
  const Vectors<Real>& p = particles.position;
  Locks locks(grid.cells());
  Failure failure;

#pragma omp parallel
  {
    // Every element is one thread's; the loop's barrier ends it before any pair is added.
#pragma omp for simd schedule(static)
    for (int i = 0; i < particles.count; ++i) density[i] = density_term(h2, Real(0));  // each particle's own term

    std::vector<floatv> sum;
    // Threads share no particle of a private cell; a shared cell's densities are read and written under its lock only.
#pragma omp for schedule(static, 1)
    for (const SubGrid& sub_grid : sub_grids.sub_grid)
      failure.guard([&] {
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
                    const Vector3<floatv> dp = repeat_at(p, i) - load(pointers(p), j);
                    const floatv r2 = dot(dp, dp);
                    const maskv near = inside & (r2 < h2);
                    const floatv term = select(near, density_term(h2, r2), 0.f);
                    sum[i - own.begin] += term;
                    store(&density[j], load(&density[j], inside) + term, inside);
                  }
              });
              const int cell = grid.cell(x, y, z);
              const Guard guard(locks, sub_grids.shared[cell] ? cell : Piece::no_lock);
              for (int i = own.begin; i < own.end; ++i) density[i] += reduce_add(sum[i - own.begin]);
            }
      });

#pragma omp for simd schedule(static)
    for (int i = 0; i < particles.count; ++i) density[i] = density_of(model, density[i]);
  }
  failure.rethrow();
}

// Room in a list for n neighbours, written a whole vector at a time. New elements are zero, the index of a particle.
template <class T>
void make_room(Array<T>& list, std::size_t n) {
  if (list.size() < padded(n)) list.resize(2 * padded(n));
}

// Where pairs are written (neighbours.h).
struct Lists {
  std::int32_t* list;
  Real* distance_2;
  std::int32_t* end;
};

// Tests the particles of a block of cells against those of its candidates that come later in cell order, so that each
// pair is met once. Writes the pairs from entry `end` on and returns the new end; adds their terms to sum_of of both
// particles. Not inlined: among the registers of its caller its inner loop took 6 % longer.
[[gnu::noinline]] int find_pairs(const Run own, Candidates& candidates, const Vectors<Real>& position, const Real h2,
                                 const Lists to, int end, Real* sum_of) {
  // Held in registers: to the compiler, the stores below could change what arrays point to.
  const auto [cx, cy, cz, index, count] = candidates.pointers();
  float* const sums = candidates.sum.data();
  const Real *px = position.x.data(), *py = position.y.data(), *pz = position.z.data();
  for (int k = 0; k < count; k += lanes) store(sums + k, floatv(0.f));
  for (int i = own.begin; i < own.end; ++i) {
    const Vector3<floatv> p_i = {px[i], py[i], pz[i]};
    floatv sum = 0;
    for (int k = 0; k < count; k += lanes) {
      const intv j = load(index + k);
      const Vector3<floatv> dp = p_i - Vector3<floatv>{load(cx + k), load(cy + k), load(cz + k)};
      const floatv r2 = dot(dp, dp);
      const maskv near = (r2 < h2) & (j > i);
      const floatv term = select(near, density_term(h2, r2), 0.f);
      sum += term;
      store(sums + k, load(sums + k) + term);
      store(to.list + end, compress(near, j));
      store(to.distance_2 + end, compress(near, r2));
      end += lockstep::count(near);
    }
    to.end[i] = end;
    sum_of[i] += reduce_add(sum);
  }
  for (int k = 0; k < count; ++k) sum_of[index[k]] += sums[k];
  return end;
}

}  // namespace

void densities_cell_locks(const Model<Real>& model, const Grid<Real>& grid, const Particles<Real>& particles,
                          Neighbours<Real>&, std::span<Real> density) {
  densities_symmetric(model, grid, particles, density, make_cell_locks(grid, omp_get_max_threads()));
}

void densities_sub_grid(const Model<Real>& model, const Grid<Real>& grid, const Particles<Real>& particles,
                        Neighbours<Real>&, std::span<Real> density) {
  densities_symmetric(model, grid, particles, density, make_sub_grids(grid, omp_get_max_threads()));
}

void densities_owner_gather(const Model<Real>& model, const Grid<Real>& grid, const Particles<Real>& particles,
                            Neighbours<Real>& neighbours, std::span<Real> density) {
  const Vectors<Real>& p = particles.position;
  const int rows = grid.y.cells * grid.z.cells;
  require_lists_fit_in_parallel(grid);

  Failure failure;
#pragma omp parallel
  {
    Candidates candidates;
    // A row of cells writes the densities and the lists of its own particles alone. Rows differ in work, hence dynamic.
#pragma omp for schedule(dynamic, 4)
    for (int row = 0; row < rows; ++row)
      failure.guard([&] {
        const int y = row % grid.y.cells, z = row / grid.y.cells;
        Array<std::int32_t>& list = neighbours.row[row];
        int end = 0;
        make_room(list, 0);
        for (int x = 0; x < grid.x.cells; ++x) {
          const Run own = row_run(grid, x, x, y, z);
          if (own.begin == own.end) continue;
          candidates.pack(own, neighbour_runs(grid, x, y, z), p, model.smoothing_length_2);
          // Copies held in registers: to the compiler, the stores below could change the originals.
          const Real h2 = model.smoothing_length_2;
          const auto [cx, cy, cz, index, count] = candidates.pointers();
          for (int i = own.begin; i < own.end; ++i) {
            make_room(list, std::size_t(end) + count);
            std::int32_t* const to = list.data();
            const Vector3<floatv> p_i = repeat_at(p, i);
            floatv sum = 0;
            for (int k = 0; k < count; k += lanes) {
              const intv j = load(index + k);
              const Vector3<floatv> dp = p_i - Vector3<floatv>{load(cx + k), load(cy + k), load(cz + k)};
              const floatv r2 = dot(dp, dp);
              sum += select(r2 < h2, density_term(h2, r2), 0.f);  // of i itself, too: its own term
              const maskv near = (r2 < h2) & (j != i);
              store(to + end, compress(near, j));
              end += lockstep::count(near);
            }
            neighbours.end[i] = end;
            density[i] = density_of(model, reduce_add(sum));
          }
        }
      });
  }
  failure.rethrow();
}

void densities_pair_lists(const Model<Real>& model, const Grid<Real>& grid, const Particles<Real>& particles,
                          Neighbours<Real>& neighbours, std::span<Real> density) {
  const Real h2 = model.smoothing_length_2;
  Real* const reaction = neighbours.scratch.data();
  require_lists_fit_in_parallel(grid);

  Failure failure;
#pragma omp parallel
  {
    Candidates candidates;
    Array<Real> sums;
    // A plane writes the lists and the densities of its own particles and the reaction of the next plane's, and no
    // other does.
#pragma omp for schedule(dynamic)
    for (int z = 0; z < grid.z.cells; ++z)
      failure.guard([&] {
        const Run own = plane_run(grid, z, z), both = plane_run(grid, z, z + 1);
        sums.assign(padded(both.end - both.begin), 0);
        Array<std::int32_t>& list = neighbours.plane[z];
        Array<Real>& distance_2 = neighbours.distance_2[z];
        int end = 0;
        make_room(list, 0);
        make_room(distance_2, 0);
        for (int y = 0; y < grid.y.cells; ++y)
          for (int x = 0; x < grid.x.cells; x += block_cells) {
            const int x_last = x + block_cells - 1;
            const Run block = row_run(grid, x, x_last, y, z);
            if (block.begin == block.end) continue;
            candidates.pack(block, forward_runs(grid, x, x_last, y, z), particles.position, h2);
            const std::size_t room = end + std::size_t(block.end - block.begin) * candidates.count;
            make_room(list, room);
            make_room(distance_2, room);
            const Lists lists = {list.data(), distance_2.data(), neighbours.end.data()};
            end = find_pairs(block, candidates, particles.position, h2, lists, end, sums.data() - both.begin);
          }
        std::copy_n(sums.begin(), own.end - own.begin, density.begin() + own.begin);
        std::copy(sums.begin() + (own.end - own.begin), sums.begin() + (both.end - both.begin), reaction + own.end);
        if (z == 0) std::fill(reaction, reaction + own.end, 0.f);
      });

    // Every element is one thread's.
#pragma omp for simd schedule(static)
    for (int i = 0; i < particles.count; ++i)
      density[i] = density_of(model, density_term(h2, Real(0)) + density[i] + reaction[i]);
  }
  failure.rethrow();
}

}  // namespace lockstep::fluid::openmp
