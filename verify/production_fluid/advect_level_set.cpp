// The level set that moves with the velocity, as the verifier and the benchmark see it: bitwise with the serial twin,
// padding included, which no kernel writes.
#include "common/production_fluid/advect_level_set.h"

#include "verify/production_fluid/advection.h"
#include "verify/production_fluid/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify {

// What the kernel changes.
struct AdvectedLevelSet {
  production_fluid::Field<float> phi;
};
template <Same<AdvectedLevelSet> A, class F>
void for_each_array(A& advected, const F& f) {
  f("phi", advected.phi.value, advected.phi.value.size());
}

namespace {

using namespace production_fluid;
using namespace production_fluid_inputs;

Case make(const std::string& path) {
  const auto in = inputs(path);
  const auto motion = std::make_shared<const Motion>(motion_of(in->scene.fluid));
  AdvectedLevelSet start{in->scene.fluid.phi};
  poison(start);
  const auto with = [in, motion](AdvectLevelSet<float>* advect_level_set) {
    return [in, motion, advect_level_set](AdvectedLevelSet& advected) {
      advect_level_set(in->scene.fluid.phi, motion->velocity, motion->dt, advected.phi);
    };
  };
  const double cells = cells_of(*in);
  return make_case<AdvectedLevelSet>({
      .start = std::make_shared<const AdvectedLevelSet>(std::move(start)),
      .serial = with(serial::advect_level_set),
      .best_serial = nullptr,
      .openmp = with(openmp::advect_level_set),
      .compare = nullptr,
      // phi and three components read, phi written; three means of two and where the centre is.
      .work = {cells, "cells", 20 * cells, (3 * 2 + 3 + flops_of_trace) * cells},
  });
}

const Register advect_level_set{
    {.name = "production_fluid/advect_level_set", .place = 1, .forms = {{.make = make, .scenes = advection_scenes()}}}};

}  // namespace
}  // namespace lockstep::verify
