// Spray for the cases of the kernels that make it and move it.
#pragma once

#include "common/production_fluid/particles.h"
#include "common/production_fluid/state.h"
#include "verify/kernel.h"

namespace lockstep::verify::production_fluid_inputs {

// Drops anywhere in the box, also in liquid and obstacles, up to 3 m/s fast along each axis.
production_fluid::Spray<float> spray(const production_fluid::Fluid<float>& fluid, int count);

// one_cell has fewer particles than lanes; drops leave through the top of open_top.
inline Scenes spray_scenes() {
  return {.verify = {"one_cell", "obstacle_48", "drop_64", "open_top"},
          .more = {"drop_128", "drop_256"},
          .bench = {"drop_128"},
          .tsan = {"obstacle_48"}};
}

}  // namespace lockstep::verify::production_fluid_inputs
