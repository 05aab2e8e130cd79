// Contract: puts the particles in cell order, so that the particles of a cell, and of a row of cells along x, are one
// run.
//
// In:      grid (shape only), particles in any order, anywhere (outside the domain too).
// Out:     particles stably sorted by cell: by cell index, and within a cell in the order they came in.
//          grid.cell_begin[c] .. cell_begin[c + 1] is the run of cell c.
// Scratch: sorted, of the same count; its content afterwards is unspecified.
// Errors:  std::bad_alloc before any particle moves; limits.h counts what the sort allocates.
// Source:  [LRB08] "Game Fluids via SPH", Figure 3; "Thread Synchronization and software locks" for the linked lists.
#pragma once

#include "common/fluid/grid.h"
#include "common/fluid/particles.h"

namespace lockstep::fluid {

template <class Real>
using RebuildGrid = void(Grid<Real>& grid, Particles<Real>& particles, Particles<Real>& sorted);

namespace serial {
RebuildGrid<float> rebuild_grid;
RebuildGrid<double> rebuild_grid;
}  // namespace serial

namespace openmp {
RebuildGrid<float> rebuild_grid_counting_sort;  // the serial algorithm over blocks of particles
RebuildGrid<float> rebuild_grid_linked_lists;   // the paper's: a list a cell, particles inserted under its lock
}  // namespace openmp

}  // namespace lockstep::fluid
