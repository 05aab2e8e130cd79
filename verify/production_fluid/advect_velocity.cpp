// The velocity that moves with itself, as the verifier and the benchmark see it: bitwise with the serial twin, padding
// included, which no kernel writes.
#include "common/production_fluid/advect_velocity.h"

#include <concepts>

#include "verify/production_fluid/advection.h"
#include "verify/production_fluid/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::production_fluid_advect_velocity {

// What the kernel changes, and its scratch.
struct AdvectedVelocity {
  production_fluid::Faces<float> velocity;
  production_fluid::Arrived<production_fluid::Faces<float>> arrived;
};
template <Same<AdvectedVelocity> A, class F>
void for_each_array(A& advected, const F& f) {
  for_each_array(advected.velocity, f);
}

namespace {

using namespace production_fluid;
using namespace production_fluid_inputs;

template <class Advect>
Case make(const std::string& path, Advect* serial, Advect* openmp) {
  constexpr bool corrects = std::same_as<Advect, AdvectVelocityMacCormack<float>>;
  const auto in = inputs(path);
  const auto motion = std::make_shared<const Motion>(motion_of(in->scene.fluid));
  AdvectedVelocity start{motion->velocity, {}};
  poison(start);
  if (corrects) {
    const auto& [u, v, w] = motion->velocity;
    const Faces<float> scratch = {scratch_of(u), scratch_of(v), scratch_of(w)};
    start.arrived = {scratch, scratch, scratch};
  }
  const auto with = [motion](Advect* advect_velocity) {
    return [motion, advect_velocity](AdvectedVelocity& advected) {
      if constexpr (corrects)
        advect_velocity(motion->velocity, motion->dt, advected.velocity, advected.arrived);
      else
        advect_velocity(motion->velocity, motion->dt, advected.velocity);
    };
  };
  const double cells = cells_of(*in);
  // About one face of each component a cell; two means of four and where the face is.
  constexpr double flops = 2 * 4 + 3 + flops_of_trace;
  return make_case<AdvectedVelocity>({
      .start = std::make_shared<const AdvectedVelocity>(std::move(start)),
      .serial = with(serial),
      .best_serial = nullptr,
      .openmp = with(openmp),
      .compare = nullptr,
      // Three components read and written. For the correction they are read twice, and what arrived, with its bounds,
      // is written and read.
      .work = {cells, "cells", (corrects ? 108 : 24) * cells,
               3 * (corrects ? 2 * flops + flops_of_correction : flops) * cells},
  });
}

const Register advect_velocity{
    {.name = "production_fluid/advect_velocity",
     .place = 2,
     .serial_forms = {"semi_lagrangian", "maccormack"},
     .forms = {{.name = "semi_lagrangian",
                .make =
                    [](const std::string& path) {
                      return make<AdvectVelocity<float>>(path, serial::advect_velocity_semi_lagrangian,
                                                         openmp::advect_velocity_semi_lagrangian);
                    },
                .scenes = advection_scenes()},
               {.name = "maccormack",
                .make =
                    [](const std::string& path) {
                      return make<AdvectVelocityMacCormack<float>>(path, serial::advect_velocity_maccormack,
                                                                   openmp::advect_velocity_maccormack);
                    },
                .scenes = advection_scenes()}}}};

}  // namespace
}  // namespace lockstep::verify::production_fluid_advect_velocity
