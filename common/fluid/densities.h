// Contract: the density at every particle,
//
//   density_i = density_coefficient * sum over j with |p_i - p_j| < h, i itself among them, of (h^2 - |p_i - p_j|^2)^3
//
// In:      particles in cell order, with grid.cell_begin to match (rebuild_grid).
// Out:     neighbours, by the owner-gather forms: everyone within h, in no order that callers may rely on. The symmetric forms
//          leave them alone.
//          density[i] for i < count, kg/m^3; the array holds padded(count) elements.
// Errors:  InputError, from the owner-gather forms, where particles crowd so that lists cannot hold them (neighbours.h).
// Source:  the poly6 kernel of [Mueller 2003]; [LRB08] "Game Fluids via SPH" and Figure 9; notes/fluid.md.
#pragma once

#include <span>

#include "common/fluid/grid.h"
#include "common/fluid/neighbours.h"
#include "common/fluid/particles.h"

namespace lockstep::fluid {

template <class Real>
using Densities = void(const Model<Real>& model, const Grid<Real>& grid, const Particles<Real>& particles, Neighbours<Real>& neighbours,
                       std::span<Real> density);

namespace serial {
Densities<float> densities_symmetric, densities_owner_gather, densities_pair_lists;
Densities<double> densities_symmetric, densities_owner_gather, densities_pair_lists;
}  // namespace serial

namespace openmp {
Densities<float> densities_cell_locks;    // symmetric, every update of a cell under that cell's lock
Densities<float> densities_sub_grid;      // symmetric, locks only for cells that two threads' sub-grids touch
Densities<float> densities_owner_gather;  // each particle sums its own neighbours: twice the tests, no lock
Densities<float> densities_pair_lists;    // symmetric, a plane of cells at a time in scratch of its own: no lock
}  // namespace openmp

}  // namespace lockstep::fluid
