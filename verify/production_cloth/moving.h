// Cloths that have moved for a while, as whole steps and their kernels find them.
#pragma once

#include <memory>
#include <string>

#include "common/production_cloth/step.h"
#include "verify/kernel.h"

namespace lockstep::production_cloth {

// A cloth that the serial step has brought to where a step needs zones, in its first hundred steps; else to the last of
// them in which something met; else to the first with near pairs; else to the last of them. The first step of all would
// not be typical: its damping has no guess from earlier steps.
struct MovingInputs {
  Cloth<float> cloth;
  Motion<float> motion;
  Script<float> script;  // of the next step
};

double bytes_of(const MovingInputs& inputs);

}  // namespace lockstep::production_cloth

namespace lockstep::verify {

production_cloth::Cloth<float> make_cloth(const production_cloth::Scene& scene);
production_cloth::Motion<float> motion_at_rest(const production_cloth::Scene& scene);

// rad/s: the highest frequency of the cloth's elasticity at rest, with held vertices. By power iteration in double.
double highest_frequency(const production_cloth::Scene& scene);

// Throws InputError, in one line that says how many substeps suffice, where elastic forces, which are explicit, make
// the step unstable: time step > 2 / highest frequency.
void require_stability(const production_cloth::Scene& scene);

}  // namespace lockstep::verify

namespace lockstep::verify::production_cloth_inputs {

std::shared_ptr<const production_cloth::MovingInputs> moving_inputs(const std::string& path);

// Those that whole steps take.
Scenes moving_scenes();

}  // namespace lockstep::verify::production_cloth_inputs
