// Particles beside the surface of a scene, as the kernels find them.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "common/production_fluid/particles.h"

namespace lockstep::verify::production_fluid_inputs {

// A hash of a number, from 0 to 1.
double random_of(std::uint64_t x);

// Up to sixteen a block, outside obstacles, where |phi| <= 3 h; sorted. One in sixteen has the sign of the other side.
// Positions come from a hash of block and number, so they do not depend on any kernel.
std::shared_ptr<const production_fluid::Particles<float>> particles(const std::string& path);

}  // namespace lockstep::verify::production_fluid_inputs
