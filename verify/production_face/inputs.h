// Scenes of the production face as the kernels find them.
#pragma once

#include <memory>
#include <string>

#include "common/production_face/scene.h"
#include "verify/kernel.h"

namespace lockstep::verify::production_face_inputs {

std::shared_ptr<const production_face::Scene> inputs(const std::string& path);

// What the scene's pose makes of its body, by the serial update_state, made definite.
std::shared_ptr<const production_face::Strained<float>> strained(const std::string& path);

// Those that all kernels take.
Scenes body_scenes();

}  // namespace lockstep::verify::production_face_inputs
