// What the cases of advection and of particles share.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/production_fluid/state.h"
#include "verify/kernel.h"

namespace lockstep::verify::production_fluid_inputs {

// What moves the fluid of a scene, and how long.
struct Motion {
  production_fluid::Faces<float> velocity;
  float dt = 0;  // s
};

// The velocity of a scene vanishes at the sides of the box, which would hide what is read there. So a flow is added,
// out through the sides along x and z, where feet then lie inside, and in along y, where they lie outside. In the step,
// the largest component moves .9 of a cell. One brick (common/production_fluid/bricks.h) stands still in a flow that
// does not, so its faces must be traced.
inline Motion motion_of(const production_fluid::Fluid<float>& fluid) {
  Motion motion{fluid.velocity, 0};
  float fastest = 0;
  const auto add = [&](production_fluid::Field<float>& component, float out, const auto& share) {
    for (int z = 0; z < component.nz; ++z)
      for (int y = 0; y < component.ny; ++y)
        for (int x = 0; x < component.nx; ++x) {
          float& value = component(x, y, z);
          const bool is_still = x / 16 == 1 && y / 4 == 1 && z / 4 == 1;
          value = is_still ? 0 : value + out * (2 * share(x, y, z) - 1);
          fastest = std::max(fastest, std::abs(value));
        }
  };
  add(motion.velocity.u, .2f, [&](int x, int, int) { return float(x) / fluid.nx; });
  add(motion.velocity.v, -.1f, [&](int, int y, int) { return float(y) / fluid.ny; });
  add(motion.velocity.w, .15f, [&](int, int, int z) { return float(z) / fluid.nz; });
  motion.dt = .9f * fluid.spacing / fastest;
  return motion;
}

// Scratch of a field's shape: NaN at every point, since a kernel may not read what it has not written.
inline production_fluid::Field<float> scratch_of(production_fluid::Field<float> field) {
  for (int z = 0; z < field.nz; ++z)
    for (int y = 0; y < field.ny; ++y)
      for (int x = 0; x < field.nx; ++x) field(x, y, z) = std::numeric_limits<float>::quiet_NaN();
  return field;
}

// Of one value, given the velocity at its point: the middle 6; the velocity there, three into the grids of cells, six
// fractions, three times seven interpolations of 3; the foot 6; the value there, 3, 3 and seven interpolations.
// Comparisons do not count.
inline constexpr double flops_of_trace = 6 + (3 + 6 + 3 * 21) + 6 + (3 + 3 + 21);
inline constexpr double flops_of_correction = 3;

// one_cell is narrower than a vector.
inline Scenes advection_scenes() {
  return {.verify = {"one_cell", "obstacle_48", "drop_64"},
          .more = {"drop_128", "drop_256"},
          .bench = {"drop_128"},
          .tsan = {"obstacle_48"}};
}

}  // namespace lockstep::verify::production_fluid_inputs
