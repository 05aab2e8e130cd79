// One frame of the game fluid.
//
// Source: [LRB08] "Game Fluids via SPH" and Figure 7. The contract stands in common/fluid/step.h.
#include "common/fluid/step.h"

#include "common/fluid/advance.h"
#include "common/fluid/collisions.h"
#include "common/fluid/densities.h"
#include "common/fluid/forces.h"
#include "common/fluid/rebuild_grid.h"
#include "common/real.h"

namespace lockstep::fluid::openmp {
namespace {

void step(Fluid<Real>& fluid, RebuildGrid<Real> rebuild_grid, Densities<Real> densities, Forces<Real> forces) {
  auto& [model, grid, particles, sorted, neighbours, density, acceleration] = fluid;
  rebuild_grid(grid, particles, sorted);
  densities(model, grid, particles, neighbours, density);
  forces(model, grid, particles, neighbours, density, acceleration);
  collisions(model, grid, particles, acceleration);
  advance(model, grid, acceleration, particles);
}

}  // namespace

void step_cell_locks(Fluid<Real>& fluid) {
  step(fluid, rebuild_grid_linked_lists, densities_cell_locks, forces_cell_locks);
}
void step_sub_grid(Fluid<Real>& fluid) { step(fluid, rebuild_grid_linked_lists, densities_sub_grid, forces_sub_grid); }
void step_owner_gather(Fluid<Real>& fluid) {
  step(fluid, rebuild_grid_counting_sort, densities_owner_gather, forces_owner_gather);
}
void step_pair_lists(Fluid<Real>& fluid) {
  step(fluid, rebuild_grid_counting_sort, densities_pair_lists, forces_pair_lists);
}

}  // namespace lockstep::fluid::openmp
