// How the game fluid's particles move on, as the verifier and the benchmark see it: bitwise with its serial twin.
#include "common/fluid/advance.h"

#include <array>

#include "verify/fluid/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::fluid_advance {
namespace {

using namespace fluid;
using namespace fluid_inputs;

Case advance_case(const std::string& path) {
  const auto in = inputs(path);
  const double n = in->fluid.particles.count;
  const auto with = [in](Advance<float>* form) {
    return [in, form](Particles<float>& particles) {
      form(in->fluid.model, in->fluid.grid, in->fluid.acceleration, particles);
    };
  };
  return make_case<Particles<float>>({
      .start = std::shared_ptr<const Particles<float>>(in, &in->fluid.particles),
      .serial = with(serial::advance),
      .best_serial = nullptr,
      .openmp = with(openmp::advance),
      .compare = [in](const auto& openmp,
                      const auto& serial) { return bitwise(openmp, serial, particle_value_name(*in)); },
      .work = {n, "particles", 72 * n, 3 * 10 * n, lanes_in_use(std::array{n})},
  });
}

const Register advance{
    {.name = "fluid/advance", .place = 5, .forms = {{.make = advance_case, .scenes = scenes_with()}}}};

}  // namespace
}  // namespace lockstep::verify::fluid_advance
