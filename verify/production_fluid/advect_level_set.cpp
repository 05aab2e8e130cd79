// The level set that moves with the velocity, as the verifier and the benchmark see it: bitwise with the serial twin,
// padding included, which no kernel writes.
#include "common/production_fluid/advect_level_set.h"

#include <concepts>

#include "verify/production_fluid/advection.h"
#include "verify/production_fluid/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::production_fluid_advect_level_set {

// What the kernel changes, and its scratch.
struct AdvectedLevelSet {
  production_fluid::Field<float> phi;
  production_fluid::Arrived<production_fluid::Field<float>> arrived;
};
template <Same<AdvectedLevelSet> A, class F>
void for_each_array(A& advected, const F& f) {
  f("phi", advected.phi.value, advected.phi.value.size());
}

namespace {

using namespace production_fluid;
using namespace production_fluid_inputs;

template <class Advect>
Case make(const std::string& path, Advect* serial, Advect* openmp) {
  constexpr bool corrects = std::same_as<Advect, AdvectLevelSetMacCormack<float>>;
  const auto in = inputs(path);
  const auto motion = std::make_shared<const Motion>(motion_of(in->scene.fluid));
  AdvectedLevelSet start{in->scene.fluid.phi, {}};
  poison(start);
  if (corrects) {
    const Field<float> scratch = scratch_of(in->scene.fluid.phi);
    start.arrived = {scratch, scratch, scratch};
  }
  const auto with = [in, motion](Advect* advect_level_set) {
    return [in, motion, advect_level_set](AdvectedLevelSet& advected) {
      if constexpr (corrects)
        advect_level_set(in->scene.fluid.phi, motion->velocity, motion->dt, advected.phi, advected.arrived);
      else
        advect_level_set(in->scene.fluid.phi, motion->velocity, motion->dt, advected.phi);
    };
  };
  const double cells = cells_of(*in);
  // Three means of two and where the centre is.
  constexpr double flops = 3 * 2 + 3 + flops_of_trace;
  return make_case<AdvectedLevelSet>({
      .start = std::make_shared<const AdvectedLevelSet>(std::move(start)),
      .serial = with(serial),
      .best_serial = nullptr,
      .openmp = with(openmp),
      .compare = nullptr,
      // phi and three components read, phi written. For the correction these are read twice, and what arrived, with its
      // bounds, is written and read.
      .work = {cells, "cells", (corrects ? 60 : 20) * cells,
               (corrects ? 2 * flops + flops_of_correction : flops) * cells},
  });
}

const Register advect_level_set{
    {.name = "production_fluid/advect_level_set",
     .place = 1,
     .serial_forms = {"semi_lagrangian", "maccormack"},
     .forms = {{.name = "semi_lagrangian",
                .make =
                    [](const std::string& path) {
                      return make<AdvectLevelSet<float>>(path, serial::advect_level_set_semi_lagrangian,
                                                         openmp::advect_level_set_semi_lagrangian);
                    },
                .scenes = advection_scenes()},
               {.name = "maccormack",
                .make =
                    [](const std::string& path) {
                      return make<AdvectLevelSetMacCormack<float>>(path, serial::advect_level_set_maccormack,
                                                                   openmp::advect_level_set_maccormack);
                    },
                .scenes = advection_scenes()}}}};

}  // namespace
}  // namespace lockstep::verify::production_fluid_advect_level_set
