// What walls do to the game fluid, as the verifier and the benchmark see it: bitwise with its serial twin.
#include "common/fluid/collisions.h"

#include <array>

#include "verify/fluid/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::fluid_collisions {
namespace {

using namespace fluid;
using namespace fluid_inputs;

struct State {
  Vectors<float> acceleration;
  int count;
};

template <Same<State> S, class F>
void for_each_array(S& state, const F& f) {
  f("acceleration", state.acceleration, state.count);
}

Case collisions_case(const std::string& path) {
  const auto in = inputs(path);
  const double n = in->fluid.particles.count;
  const auto with = [in](Collisions<float>* form) {
    return [in, form](State& s) { form(in->fluid.model, in->fluid.grid, in->fluid.particles, s.acceleration); };
  };
  return make_case<State>({
      .start = std::make_shared<State>(State{in->fluid.acceleration, in->fluid.particles.count}),
      .serial = with(serial::collisions),
      .best_serial = nullptr,
      .openmp = with(openmp::collisions),
      .compare = [in](const State& openmp,
                      const State& serial) { return bitwise(openmp, serial, particle_value_name(*in)); },
      .work = {n, "particles", 60 * n, 3 * 16 * n, lanes_in_use(std::array{n})},
  });
}

const Register collisions{
    {.name = "fluid/collisions", .place = 4, .forms = {{.make = collisions_case, .scenes = scenes_with()}}}};

}  // namespace
}  // namespace lockstep::verify::fluid_collisions
