// Scenes of the production cloth as the kernels find them.
#pragma once

#include <memory>
#include <string>

#include "common/production_cloth/scene.h"
#include "verify/kernel.h"

namespace lockstep::verify::production_cloth_inputs {

std::shared_ptr<const production_cloth::Scene> inputs(const std::string& path);

// 1/kg, lumped, padded; 0 of a vertex that is held.
Array<float> inverse_masses(const production_cloth::Scene& scene);

// Positions at rest, in float.
Vectors<float> rest_positions(const production_cloth::Scene& scene);

// Those that all kernels take.
Scenes all_scenes();

}  // namespace lockstep::verify::production_cloth_inputs
