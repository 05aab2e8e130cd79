#include "verify/production_fluid/spray.h"

#include "verify/production_fluid/particles.h"

namespace lockstep::verify::production_fluid_inputs {

using namespace production_fluid;

Spray<float> spray(const Fluid<float>& fluid, int count) {
  Spray<float> made;
  resize(made, count);
  const float h = fluid.spacing;
  for (int i = 0; i < count; ++i) {
    const auto any = [&](int k) { return static_cast<float>(random_of(8 * i + k)); };
    store(made.position, i, Vector3<float>{h * fluid.nx * any(0), h * fluid.ny * any(1), h * fluid.nz * any(2)});
    store(made.velocity, i, Vector3<float>{6 * any(3) - 3, 6 * any(4) - 3, 6 * any(5) - 3});
    made.radius[i] = h * (least_radius + (most_radius - least_radius) * any(6));
  }
  return made;
}

}  // namespace lockstep::verify::production_fluid_inputs
