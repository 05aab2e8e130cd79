// The velocity's continuation into the air, as the verifier and the benchmark see it: bitwise with the serial twin, every
// face and the padding. It starts from what the serial texts project.
#include "common/production_fluid/extrapolate.h"

#include "common/production_fluid/project.h"
#include "verify/production_fluid/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify {
namespace {

using namespace production_fluid;
using namespace production_fluid_inputs;

Case make(const std::string& path) {
  const auto in = inputs(path);
  const Fluid<float>& fluid = in->scene.fluid;
  const auto start = std::make_shared<Faces<float>>(fluid.velocity);
  serial::project(fluid, in->system, *pressure(path), *start);
  const auto with = [in](Extrapolate<float>* extrapolate) {
    return [in, extrapolate](Faces<float>& faces) { extrapolate(in->scene.fluid, 3 * in->scene.fluid.spacing, faces); };
  };
  const double cells = cells_of(*in), faces = faces_of(*in);
  return make_case<Faces<float>>({
      .start = start,
      .serial = with(serial::extrapolate),
      .best_serial = nullptr,
      .openmp = with(openmp::extrapolate),
      .compare = nullptr,
      // phi and solid of a cell, and faces in the air written, of which there are half; a face's distance. The faces
      // near the liquid are few.
      .work = {faces, "faces", 8 * cells + 2 * faces, 2 * faces},
  });
}

const Register extrapolate{
    {.name = "production_fluid/extrapolate", .place = 7, .forms = {{.make = make, .scenes = pressure_scenes()}}}};

}  // namespace
}  // namespace lockstep::verify
