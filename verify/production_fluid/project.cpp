// The pressure's push, as the verifier and the benchmark see it: bitwise with the serial twin, every face and the
// padding. The pressure is the serial text's.
#include "common/production_fluid/project.h"

#include "verify/production_fluid/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::production_fluid_project {
namespace {

using namespace production_fluid;
using namespace production_fluid_inputs;

Case make(const std::string& path) {
  const auto in = inputs(path);
  const auto q = pressure(path);
  const auto with = [in, q](Project<float>* project) {
    return [in, q, project](Faces<float>& faces) { project(in->scene.fluid, in->system, *q, faces); };
  };
  const double cells = cells_of(*in), faces = faces_of(*in);
  return make_case<Faces<float>>({
      .start = std::make_shared<const Faces<float>>(velocity(*in)),
      .serial = with(serial::project),
      .best_serial = nullptr,
      .openmp = with(openmp::project),
      .compare = nullptr,
      // phi, solid and q of a cell, a face read and written; a difference, a product, theta and its inverse.
      .work = {faces, "faces", 16 * cells + 8 * faces, 6 * faces},
  });
}

const Register project{
    {.name = "production_fluid/project", .place = 6, .forms = {{.make = make, .scenes = pressure_scenes()}}}};

}  // namespace
}  // namespace lockstep::verify::production_fluid_project
