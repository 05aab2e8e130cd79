// What the cases of both advections share.
#pragma once

#include <algorithm>
#include <cmath>

#include "common/production_fluid/state.h"
#include "verify/kernel.h"

namespace lockstep::verify::production_fluid_inputs {

// A step in which the fastest velocity moves .9 of a cell; where all are at rest, 0.01 s. In s.
inline float advection_step(const production_fluid::Fluid<float>& fluid) {
  float fastest = 0;
  for_each_array(fluid.velocity, [&](const char*, const Array<float>& component, std::size_t) {
    for (const float v : component) fastest = std::max(fastest, std::abs(v));
  });
  return fastest > 0 ? .9f * fluid.spacing / fastest : .01f;
}

// Of one value, given the velocity at its point: the middle 6; the velocity there, three into the grids of cells, six
// fractions, three times seven interpolations of 3; the foot 6; the value there, 3, 3 and seven interpolations.
// Comparisons do not count.
inline constexpr double flops_of_trace = 6 + (3 + 6 + 3 * 21) + 6 + (3 + 3 + 21);

// one_cell is narrower than a vector.
inline Scenes advection_scenes() {
  return {.verify = {"one_cell", "obstacle_48", "drop_64"},
          .more = {"drop_128"},
          .bench = {"drop_128"},
          .tsan = {"obstacle_48"}};
}

}  // namespace lockstep::verify::production_fluid_inputs
