// The velocity that moves with itself, as the verifier and the benchmark see it: bitwise with the serial twin, padding
// included, which no kernel writes.
#include "common/production_fluid/advect_velocity.h"

#include "verify/production_fluid/advection.h"
#include "verify/production_fluid/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify {
namespace {

using namespace production_fluid;
using namespace production_fluid_inputs;

Case make(const std::string& path) {
  const auto in = inputs(path);
  const auto motion = std::make_shared<const Motion>(motion_of(in->scene.fluid));
  Faces<float> start = motion->velocity;
  poison(start);
  const auto with = [motion](AdvectVelocity<float>* advect_velocity) {
    return
        [motion, advect_velocity](Faces<float>& advected) { advect_velocity(motion->velocity, motion->dt, advected); };
  };
  const double cells = cells_of(*in);
  return make_case<Faces<float>>({
      .start = std::make_shared<const Faces<float>>(std::move(start)),
      .serial = with(serial::advect_velocity),
      .best_serial = nullptr,
      .openmp = with(openmp::advect_velocity),
      .compare = nullptr,
      // Three components read and written, about one face of each a cell; two means of four and where the face is.
      .work = {cells, "cells", 24 * cells, 3 * (2 * 4 + 3 + flops_of_trace) * cells},
  });
}

const Register advect_velocity{
    {.name = "production_fluid/advect_velocity", .place = 2, .forms = {{.make = make, .scenes = advection_scenes()}}}};

}  // namespace
}  // namespace lockstep::verify
