// Spray that flies for a step, as the verifier and the benchmark see it: bitwise with the serial twin.
#include "common/production_fluid/advance_spray.h"

#include <algorithm>

#include "verify/production_fluid/inputs.h"
#include "verify/production_fluid/particles.h"
#include "verify/production_fluid/spray.h"
#include "verify/twin.h"

namespace lockstep::verify::production_fluid_advance_spray {

// What the kernel changes.
struct AdvancedSpray {
  production_fluid::Spray<float> spray;
  production_fluid::Particles<float> particles;
};
template <Same<AdvancedSpray> A, class F>
void for_each_array(A& advanced, const F& f) {
  for_each_array(advanced.spray, f);
  for_each_array(advanced.particles, f);
}

namespace {

using namespace production_fluid;
using namespace production_fluid_inputs;

// Some particles that are there already.
Particles<float> some_of(const Particles<float>& all) {
  Particles<float> some = all;
  resize(some, std::min(all.count, 1001));
  return some;
}

Case make(const std::string& path) {
  const auto in = inputs(path);
  constexpr int drops = 10009;
  AdvancedSpray start{spray(in->scene.fluid, drops), some_of(*particles(path))};
  const auto with = [in](AdvanceSpray<float>* advance_spray) {
    return [in, advance_spray](AdvancedSpray& advanced) {
      const Fluid<float>& fluid = in->scene.fluid;
      // At 3 m/s, that is a cell and a half.
      advance_spray(fluid, {.5f, -9.81f, .25f}, .5f * fluid.spacing, advanced.spray, advanced.particles);
    };
  };
  return make_case<AdvancedSpray>({
      .start = std::make_shared<const AdvancedSpray>(std::move(start)),
      .serial = with(serial::advance_spray),
      .best_serial = nullptr,
      .openmp = with(openmp::advance_spray),
      .compare = nullptr,
      // Seven numbers of a drop read and written, and the corners of its cell in two fields. The flight 3 and 6; where
      // it is, twice 3 and 6; two values of seven interpolations of 3. Few meet an obstacle.
      .work = {drops, "drops", (56 + 64) * drops, (9 + 2 * 9 + 2 * 21) * drops},
  });
}

const Register advance_spray{
    {.name = "production_fluid/advance_spray", .place = 15, .forms = {{.make = make, .scenes = spray_scenes()}}}};

}  // namespace
}  // namespace lockstep::verify::production_fluid_advance_spray
