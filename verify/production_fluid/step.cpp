// A frame of the production fluid, as the verifier and the benchmark see it: bitwise with the serial twin, in all that
// the next frame begins with.
#include "common/production_fluid/step.h"

#include "verify/inputs.h"
#include "verify/production_fluid/forms.h"
#include "verify/production_fluid/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::production_fluid_step {

struct Flowing {
  production_fluid::Liquid<float> liquid;
  production_fluid::StepMemory<float> memory;
};
template <Same<Flowing> S, class F>
void for_each_array(S& flowing, const F& f) {
  for_each_array(flowing.liquid, f);
}

namespace {

using namespace production_fluid;
using namespace production_fluid_inputs;

Case make(const std::string& path, const LiquidForm& form) {
  const auto in = inputs(path);
  const Model& model = in->scene.model;
  Flowing start;
  start.liquid.fluid = in->scene.fluid;
  serial::start(model, start.liquid, start.memory);
  const double bytes = 2 * lockstep::bytes_of(start.liquid);
  const auto with = [&model, in](Step<float>* step) {
    return [&model, in, step](Flowing& flowing) { step(model, flowing.liquid, flowing.memory); };
  };
  return make_case<Flowing>({
      .start = std::make_shared<const Flowing>(std::move(start)),
      .serial = with(form.serial),
      .best_serial = nullptr,
      .openmp = with(form.openmp),
      .compare = nullptr,
      // What a frame begins with, read and written. Substeps and iterations decide on the rest.
      .work = {cells_of(*in), "cells", bytes, 0},
      .restore =
          [](Flowing& now, const Flowing& start) {
            if (now.memory.phi.nx == 0) now.memory = start.memory;
            now.liquid = start.liquid;
          },
  });
}

std::vector<Form> forms() {
  std::vector<Form> all;
  for (const LiquidForm& form : liquid_forms)
    all.push_back({.name = form.name,
                   .make = [&form](const std::string& path) { return make(path, form); },
                   .scenes = {.verify = {"obstacle_48", "one_cell", "two_pockets", "open_top", "enright_32", "jet_24"},
                              .more = {"falling_drop"},
                              .bench = {"drop_64"},
                              .tsan = {"obstacle_48"}}});
  return all;
}

const Register step{
    {.name = "production_fluid/step", .place = 18, .serial_forms = {"multigrid", "mic", "marching"}, .forms = forms()}};

}  // namespace
}  // namespace lockstep::verify::production_fluid_step
