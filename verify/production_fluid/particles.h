// Particles beside the surface of a scene, as the kernels find them.
#pragma once

#include <memory>
#include <string>

#include "common/production_fluid/particles.h"

namespace lockstep::verify::production_fluid_inputs {

// Sixteen a block, in blocks nearer to the surface than particles go; sorted. One in sixteen has the sign of the other
// side. Positions come from a hash of block and number, so they do not depend on any kernel.
std::shared_ptr<const production_fluid::Particles<float>> particles(const std::string& path);

}  // namespace lockstep::verify::production_fluid_inputs
