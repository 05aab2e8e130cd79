// Puts the particles in cell order by a counting sort.
//
// Three passes: count the particles of each cell; sum the counts, which gives the begin of every cell's run; copy each
// particle to the next free place of its cell's run. Walking the particles in the order they came in makes the sort
// stable, which fixes the order within a cell and with it every later sum. Cost is linear in particles and cells, and
// since particles move little in a frame the moves are nearly sequential.
//
// Source: [LRB08] "Game Fluids via SPH", Figure 3. The contract stands in common/fluid/rebuild_grid.h.
#include "common/fluid/rebuild_grid.h"

#include <algorithm>
#include <utility>

#include "common/real.h"

namespace lockstep::fluid::serial {
namespace {

int cell_of(const Grid<Real>& grid, const Vectors<Real>& position, int i) { return cell_of(grid, at(position, i)); }

}  // namespace

void rebuild_grid(Grid<Real>& grid, Particles<Real>& particles, Particles<Real>& sorted) {
  // cell_begin[c + 1] counts cell c; summed up, cell_begin[c] is where cell c begins.
  std::fill(grid.cell_begin.begin(), grid.cell_begin.end(), 0);
  for (int i = 0; i < particles.count; ++i) ++grid.cell_begin[cell_of(grid, particles.position, i) + 1];
  for (int c = 0; c < grid.cells(); ++c) grid.cell_begin[c + 1] += grid.cell_begin[c];

  // next[c] is the next free place of cell c.
  Array<std::int32_t> next(grid.cell_begin.begin(), grid.cell_begin.end());
  for (int i = 0; i < particles.count; ++i)
    copy_particle(particles, i, sorted, next[cell_of(grid, particles.position, i)]++);
  std::swap(particles, sorted);
}

}  // namespace lockstep::fluid::serial
