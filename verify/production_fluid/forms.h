// The forms of a frame of the production fluid, by name.
#pragma once

#include <string>

#include "common/production_fluid/step.h"

namespace lockstep::verify {

struct LiquidForm {
  std::string name;
  production_fluid::Step<float>*serial, *openmp;
};

// The form that `run` takes unless told otherwise comes first.
inline const LiquidForm liquid_forms[] = {
    {"multigrid", production_fluid::serial::step_multigrid, production_fluid::openmp::step_multigrid},
    {"mic", production_fluid::serial::step_mic, production_fluid::openmp::step_mic},
    {"marching", production_fluid::serial::step_marching, production_fluid::openmp::step_marching},
};

}  // namespace lockstep::verify
