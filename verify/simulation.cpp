#include "verify/simulation.h"

#include "verify/domain.h"

namespace lockstep::verify {

Simulation make_simulation(const RunOptions& options) {
  const Domain& domain = domain_of_scene(options.scene);
  if (!domain.simulation)
    throw InputError(options.scene + ": scenes of kind " + domain.name + " have nothing to simulate");
  return domain.simulation(options);
}

}  // namespace lockstep::verify
