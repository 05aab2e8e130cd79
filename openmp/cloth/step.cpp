// One step of the game cloth.
//
// Source: [Jakobsen 2001]; [LRB08] "Cloth Simulation" and Figure 2. The contract stands in common/cloth/step.h.
#include "common/cloth/step.h"

#include "common/cloth/collide.h"
#include "common/cloth/relax.h"
#include "common/cloth/verlet.h"
#include "common/real.h"

namespace lockstep::cloth::openmp {
namespace {

void step(Cloth<Real>& cloth, Relax<Real> relax) {
  for (int substep = 0; substep < cloth.model.substeps; ++substep) {
    verlet(cloth);
    relax(cloth, cloth.model.iterations);
    collide(cloth);
  }
}

}  // namespace

void step_chains(Cloth<Real>& cloth) { step(cloth, relax_chains); }
void step_colours(Cloth<Real>& cloth) { step(cloth, relax_colours); }
void step_batches(Cloth<Real>& cloth) { step(cloth, relax_batches); }

}  // namespace lockstep::cloth::openmp
