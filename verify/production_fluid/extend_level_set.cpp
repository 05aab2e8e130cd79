// The level set in obstacles, as the verifier and the benchmark see it: bitwise with the serial twin, padding included,
// which no kernel writes.
#include "common/production_fluid/extend_level_set.h"

#include "verify/production_fluid/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::production_fluid_extend_level_set {

// What the kernel changes.
struct ExtendedLevelSet {
  production_fluid::Field<float> phi;
};
template <Same<ExtendedLevelSet> E, class F>
void for_each_array(E& extended, const F& f) {
  f("phi", extended.phi.value, extended.phi.value.size());
}

namespace {

using namespace production_fluid;
using namespace production_fluid_inputs;

// phi in obstacles is lost before the kernel runs.
Case make(const std::string& path) {
  const auto in = inputs(path);
  const Fluid<float>& fluid = in->scene.fluid;
  const auto extension = std::make_shared<const Extension<float>>(make_extension(fluid));
  ExtendedLevelSet start{fluid.phi};
  for (int z = 0; z < fluid.nz; ++z)
    for (int y = 0; y < fluid.ny; ++y)
      for (int x = 0; x < fluid.nx; ++x)
        if (is_solid(fluid.solid(x, y, z))) start.phi(x, y, z) = 1e3f * fluid.spacing;
  const auto with = [extension](ExtendLevelSet<float>* extend_level_set) {
    return [extension, extend_level_set](ExtendedLevelSet& e) { extend_level_set(*extension, e.phi); };
  };
  const double n = extension->first.back();
  return make_case<ExtendedLevelSet>({
      .start = std::make_shared<const ExtendedLevelSet>(std::move(start)),
      .serial = with(serial::extend_level_set),
      .best_serial = nullptr,
      .openmp = with(openmp::extend_level_set),
      .compare = nullptr,
      // Four places and three shares read, three values read and one written.
      .work = {n, "cells", 44 * n, 7 * n},
  });
}

const Register extend_level_set{
    {.name = "production_fluid/extend_level_set",
     .place = 17,
     .forms = {{.make = make,
                .scenes = {.verify = {"obstacle_48", "two_pockets", "drop_64"},
                           .more = {},
                           .bench = {"obstacle_48"},
                           .tsan = {"obstacle_48"}}}}}};

}  // namespace
}  // namespace lockstep::verify::production_fluid_extend_level_set
