// The game fluid's whole step, as the verifier and the benchmark see it: what verify/fluid/run.h asserts of one step
// and of a whole run. Timed is one step.
#include "common/fluid/step.h"

#include "verify/fluid/forms.h"
#include "verify/fluid/inputs.h"
#include "verify/fluid/run.h"
#include "verify/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::fluid_step {
namespace {

using namespace fluid;
using namespace fluid_inputs;

Case step_case(const std::string& path, const StepForm& form) {
  const auto in = inputs(path);
  const auto start = std::make_shared<Fluid<float>>(in->fluid);
  start->particles = in->unsorted;
  const double n = start->particles.count, cells = start->grid.cells();
  Step<float>* best = serial::step_symmetric;
  return make_case<Fluid<float>>({
      .start = start,
      .serial = form.serial,
      .best_serial = form.serial == best ? std::function<void(Fluid<float>&)>() : best,
      .openmp = form.step,
      .compare =
          [in, start, path, step = form.step](const Fluid<float>& openmp, const Fluid<float>& serial) {
            Judgement judgement{.verdict = Verdict::physical, .worst_at = ""};
            check_one_step(judgement, *start, openmp, serial);
            const auto runs = verify::inputs<FreeRuns>(path, [&] { return run_freely(*start, in->scene.frames); });
            check_free_run(judgement, *runs, in->scene.holds, *start, step);
            for (Course& course : judgement.courses) course.from = in->frames_before;
            return judgement;
          },
      .work = {n, "particles", 2 * particle_bytes * n + 4 * cells + (16 + 40 + 60 + 72) * n,
               16 * in->tested_pairs + 38 * in->near_pairs + 87 * n},
      // Particles are what a step starts from; all else it makes, or, like the room in lists, has from the frame
      // before.
      .restore = [](Fluid<float>& now, const Fluid<float>& start) { now.particles = start.particles; },
  });
}

std::vector<Form> forms() {
  std::vector<Form> all;
  for (const StepForm& form : step_forms)
    if (form.variant == "openmp")
      all.push_back({.name = form.name,
                     .make = [form](const std::string& path) { return step_case(path, form); },
                     .scenes = scenes_with({"dam_break_5k", "dam_break_35k", "dam_break_100k", "dam_break_500k"}),
                     .order_dependent = form.name != "owner_gather" && form.name != "pair_lists"});
  return all;
}

const Register step{
    {.name = "fluid/step", .place = 6, .serial_forms = {"symmetric", "owner_gather", "pair_lists"}, .forms = forms()}};

}  // namespace
}  // namespace lockstep::verify::fluid_step
