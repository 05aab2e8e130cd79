// Gravity, as the verifier and the benchmark see it: bitwise with the serial twin, every face and the padding.
#include "common/production_fluid/apply_forces.h"

#include "verify/production_fluid/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::production_fluid_apply_forces {
namespace {

using namespace production_fluid;
using namespace production_fluid_inputs;

Case make(const std::string& path) {
  const auto in = inputs(path);
  // No component zero, so that all take part.
  const auto with = [](ApplyForces<float>* apply_forces) {
    return [apply_forces](Faces<float>& faces) { apply_forces({.3f, -9.81f, .2f}, 1.f / 60, faces); };
  };
  const double faces = faces_of(*in);
  return make_case<Faces<float>>({
      .start = std::make_shared<const Faces<float>>(velocity(*in)),
      .serial = with(serial::apply_forces),
      .best_serial = nullptr,
      .openmp = with(openmp::apply_forces),
      .compare = nullptr,
      // A face is read and written.
      .work = {faces, "faces", 8 * faces, faces},
  });
}

const Register apply_forces{
    {.name = "production_fluid/apply_forces", .place = 3, .forms = {{.make = make, .scenes = pressure_scenes()}}}};

}  // namespace
}  // namespace lockstep::verify::production_fluid_apply_forces
