// Contract: the density at every particle,
//
//   density_i = max(least_density, density_coefficient * sum of (h^2 - |p_i - p_j|^2)^3)
//
// over all j with |p_i - p_j| < h, i itself among them.
//
// In:      particles in cell order, with grid.cell_begin to match (rebuild_grid).
// Out:     density[i] for i < count, kg/m^3; the array holds padded(count) elements.
//          neighbours, which the forces read. owner_gather: `row` and `end`, all particles within h of each.
//          pair_lists: `plane`, `distance_2` and `end`, each pair within h once. The symmetric forms do not write them.
//          Their order is unspecified.
// Scratch: neighbours.scratch, of openmp pair_lists.
// Errors:  owner_gather and pair_lists throw InputError where particles crowd so that lists cannot hold them
//          (require_lists_fit, neighbours.h). All openmp forms throw std::bad_alloc where memory runs out; density and
//          neighbours are then unspecified.
// Source:  the poly6 kernel of [Mueller 2003]; [LRB08] "Game Fluids via SPH" and Figure 9; notes/fluid.md.
#pragma once

#include <span>

#include "common/fluid/grid.h"
#include "common/fluid/neighbours.h"
#include "common/fluid/particles.h"

namespace lockstep::fluid {

template <class Real>
using Densities = void(const Model<Real>& model, const Grid<Real>& grid, const Particles<Real>& particles,
                       Neighbours<Real>& neighbours, std::span<Real> density);

namespace serial {
Densities<float> densities_symmetric, densities_owner_gather, densities_pair_lists;
Densities<double> densities_symmetric, densities_owner_gather, densities_pair_lists;
}  // namespace serial

namespace openmp {
Densities<float> densities_cell_locks;    // symmetric, every update of a cell under that cell's lock
Densities<float> densities_sub_grid;      // symmetric, locks only for cells that two threads' sub-grids touch
Densities<float> densities_owner_gather;  // each particle sums its own neighbours: twice the tests, no lock
Densities<float> densities_pair_lists;    // symmetric, each plane of cells in its own scratch: no lock
}  // namespace openmp

}  // namespace lockstep::fluid
