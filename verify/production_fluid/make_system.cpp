// The system of the pressure, as the verifier and the benchmark see it: bitwise with the serial twin, every array
// whole.
#include "common/production_fluid/make_system.h"

#include "verify/production_fluid/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::production_fluid_make_system {
namespace {

using namespace production_fluid;
using namespace production_fluid_inputs;

Case make(const std::string& path) {
  const auto in = inputs(path);
  System<float> start = in->system;
  poison(start);
  const auto with = [in](MakeSystem<float>* make_system) {
    return [in, make_system](System<float>& system) { make_system(in->scene.fluid, system); };
  };
  const double cells = cells_of(*in), liquid = liquid_cells_of(*in);
  return make_case<System<float>>({
      .start = std::make_shared<const System<float>>(std::move(start)),
      .serial = with(serial::make_system),
      .best_serial = nullptr,
      .openmp = with(openmp::make_system),
      .compare = nullptr,
      // phi, solid and three velocities, diagonal and right; six faces of nine operations, most of a liquid cell.
      .work = {cells, "cells", 28 * cells, 54 * liquid},
  });
}

const Register make_system{
    {.name = "production_fluid/make_system", .place = 4, .forms = {{.make = make, .scenes = pressure_scenes()}}}};

}  // namespace
}  // namespace lockstep::verify::production_fluid_make_system
