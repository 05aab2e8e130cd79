// Contract: the acceleration of every particle by pressure, viscosity and gravity,
//
//   a_i = gravity + sum over j != i with r = |p_i - p_j| < h of
//         { (p_i - p_j) Cp (h - d)^2 / d (density_i + density_j - 2 rest) + (v_j - v_i) Cv (h - d) } / (density_i
//         density_j)
//
// with d = sqrt(max(r^2, min_distance_2)). The term of (j, i) is minus that of (i, j), so momentum is conserved.
//
// In:      particles in cell order, with grid.cell_begin to match (rebuild_grid), and their densities.
//          neighbours, of owner_gather and pair_lists: the lists that the densities of the same form made. The
//          symmetric forms do not read them.
// Out:     acceleration[i] for i < count, m/s^2.
// Scratch: neighbours.scratch, of openmp owner_gather and pair_lists.
// Errors:  all openmp forms but owner_gather throw std::bad_alloc where memory runs out; acceleration is then
//          unspecified.
// Source:  [Mueller 2003] with the symmetrised terms of notes/fluid.md; [LRB08] "Thread Synchronization", Figure 9.
#pragma once

#include <span>

#include "common/fluid/grid.h"
#include "common/fluid/neighbours.h"
#include "common/fluid/particles.h"

namespace lockstep::fluid {

template <class Real>
using Forces = void(const Model<Real>& model, const Grid<Real>& grid, const Particles<Real>& particles,
                    Neighbours<Real>& neighbours, std::span<const Real> density, Vectors<Real>& acceleration);

namespace serial {
Forces<float> forces_symmetric, forces_owner_gather, forces_pair_lists;
Forces<double> forces_symmetric, forces_owner_gather, forces_pair_lists;
}  // namespace serial

namespace openmp {
Forces<float> forces_cell_locks;    // symmetric, every update of a cell under that cell's lock
Forces<float> forces_sub_grid;      // symmetric, locks only for cells that two threads' sub-grids touch
Forces<float> forces_owner_gather;  // each particle sums its own neighbours: twice the terms, no lock
// Symmetric over the densities' lists, each plane of cells in its own scratch: no lock.
Forces<float> forces_pair_lists;
}  // namespace openmp

}  // namespace lockstep::fluid
