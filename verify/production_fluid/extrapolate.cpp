// The velocity's continuation into the air, as the verifier and the benchmark see it: bitwise with the serial twin,
// every face and the padding. It starts from what the serial texts project.
#include "common/production_fluid/extrapolate.h"

#include "common/production_fluid/project.h"
#include "verify/production_fluid/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::production_fluid_extrapolate {
namespace {

using namespace production_fluid;
using namespace production_fluid_inputs;

// The scene with dents of the distance in the air, one in some hundreds of cells. A dent is two cells wide. The face
// between them is near, but nothing is known of it, and faces beside it must not take it for known. Scenes hardly have
// any such faces.
Fluid<float> dented(Fluid<float> fluid) {
  const float h = fluid.spacing;
  for (int z = 0; z < fluid.nz; ++z)
    for (int y = 0; y < fluid.ny; ++y)
      for (int x = 0; x + 1 < fluid.nx; ++x)
        if (fluid.phi(x, y, z) > 3 * h && (x + 17 * y + 101 * z) % 499 == 0)
          fluid.phi(x, y, z) = .01f * h, fluid.phi(x + 1, y, z) = .5f * h;
  return fluid;
}

Case make(const std::string& path) {
  const auto in = inputs(path);
  const auto fluid = std::make_shared<const Fluid<float>>(dented(in->scene.fluid));
  const auto start = std::make_shared<Faces<float>>(velocity(*in));
  serial::project(in->scene.fluid, in->system, *pressure(path), *start);
  const auto with = [fluid](Extrapolate<float>* extrapolate) {
    return [fluid, extrapolate](Faces<float>& faces) { extrapolate(*fluid, 3 * fluid->spacing, faces); };
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
}  // namespace lockstep::verify::production_fluid_extrapolate
