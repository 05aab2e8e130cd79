// Contract: one frame of the game fluid, time_step long: rebuild_grid, densities, forces, collisions, advance.
//
// In, out: fluid; its particles come out in the cell order of the frame's start.
// Source:  [LRB08] "Game Fluids via SPH" and Figure 7.
#pragma once

#include "common/fluid/fluid.h"

namespace lockstep::fluid {

template <class Real>
using Step = void(Fluid<Real>& fluid);

namespace serial {
Step<float> step_symmetric, step_owner_gather, step_pair_lists;
Step<double> step_symmetric, step_owner_gather, step_pair_lists;
}  // namespace serial

namespace openmp {
Step<float> step_cell_locks;    // linked lists, a lock for every cell
Step<float> step_sub_grid;      // linked lists, locks at the borders of the threads' sub-grids: the papers' scheme
Step<float> step_owner_gather;  // counting sort, no locks: the same bits at every thread count
Step<float> step_pair_lists;    // likewise, and every pair is met once
}  // namespace openmp

}  // namespace lockstep::fluid
