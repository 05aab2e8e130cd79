// The rows and benchmarks of the whole step of rigid bodies: bitwise with the serial form of the same order of
// contacts. The form `batches_run` judges a whole run by what physics conserves.
#include "common/rigid/step.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "verify/rigid/inputs.h"
#include "verify/rigid/run.h"
#include "verify/twin.h"

namespace lockstep::verify::rigid_step {
namespace {

using namespace rigid;
using namespace rigid_inputs;

struct State {
  World<float> world;
  StepMemory<float> memory;
};
// The output of a step: bodies, and the impulses that the next step starts with.
template <Same<State> S, class F>
void for_each_array(S& s, const F& f) {
  for_each_array(s.world.bodies, f);
  f("manifolds", s.memory.manifolds, s.memory.manifolds.size());
  f("impulses", s.memory.impulses, s.memory.impulses.size());
  f("kept.contact", s.memory.kept.contact, s.memory.kept.contact.size());
}

Case step_case(const std::string& path, Step<float>* serial, Step<float>* openmp, bool keeps = false) {
  const auto in = inputs(path);
  StepMemory<float> last = in->last;
  if (keeps) find_kept(*in, last.narrow_phase, last.kept);
  const auto with = [in](Step<float>* step) { return [in, step](State& s) { step(in->settings, s.world, s.memory); }; };
  const double n = in->world.bodies.count;
  return make_case<State>({
      .start = std::make_shared<const State>(State{in->world, std::move(last)}),
      .serial = with(serial),
      .best_serial = nullptr,
      .openmp = with(openmp),
      .compare = nullptr,
      .work = {n, "bodies", n * 6 * bytes_of_pose, 75 * rows_of(*in)},
  });
}

// A whole run from the scene's start. Steps have the serial bits, so the run cannot leave the serial one. In addition
// every number must be finite, momentum must change only by gravity and static bodies, to within rounding, and the
// energy must be as near to the serial run's as a serial run whose start was changed by one ulp. It prints the most
// energy that position correction adds in a step.
Case run_case(const std::string& path, Step<float>* serial, Step<float>* openmp) {
  struct State {
    Scene scene;
    int steps;
    RigidRun expected, found;
    std::vector<double> energy_forgotten, push;  // J, [step]
  };
  constexpr double body_steps = 3e5;  // the length of a run: long enough for bodies to meet, short enough to wait for
  auto s = std::make_shared<State>(State{load_scene(path), 0, {}, {}, {}, {}});
  s->steps = std::clamp(static_cast<int>(body_steps / s->scene.world.bodies.count), 5, 200);
  s->expected = run_rigid(s->scene, serial, s->steps);
  s->energy_forgotten = energy_forgotten(s->scene, serial, s->expected);
  s->push = energy_of_push(s->scene, serial, s->steps);
  const double n = static_cast<double>(s->scene.world.bodies.count) * s->steps;
  return {
      .reset = [] {},
      .serial = [s, serial] { run_rigid(s->scene, serial, s->steps); },
      .best_serial = nullptr,
      .openmp = [s, openmp] { s->found = run_rigid(s->scene, openmp, s->steps); },
      .judge =
          [s] {
            Judgement judgement{.verdict = Verdict::physical, .bound = 1, .worst_at = ""};
            for (std::size_t f = 0; f < s->found.frames.size(); ++f) {
              const RigidRun::Frame& frame = s->found.frames[f];
              const std::string at = " after step " + std::to_string(f + 1);
              const auto fail = [&](const std::string& what) {
                if (judgement.passed) judgement.worst_at = what + at;
                judgement.passed = false;
              };
              if (!std::ranges::all_of(frame.state, [](float x) { return std::isfinite(x); }))
                fail("a number is not finite");
              if (!std::ranges::equal(frame.state, s->expected.frames[f].state))
                fail("another state than the serial run's");
              if (!(frame.momentum_error <= 1)) fail("momentum is off by more than rounding");
              const double energies = std::abs(frame.energy - s->expected.frames[f].energy),
                           forgotten = s->energy_forgotten[f];
              if (!(energies <= forgotten)) fail("energy is farther from the serial run's than that is from itself");
              if (judgement.passed && frame.momentum_error >= judgement.error) {
                char text[200];
                std::snprintf(text, sizeof text,
                              "momentum%s; deepest %.2g mm; energy %.6g J, off by %.2g of %.2g; push at most %.2g J",
                              at.c_str(), 1e3 * frame.deepest, frame.energy, energies, forgotten,
                              *std::ranges::max_element(s->push));
                judgement.error = frame.momentum_error, judgement.worst_at = text;
              }
            }
            return judgement;
          },
      .hash = [s] { return hash_bytes(std::span<const float>(s->found.frames.back().state)); },
      .work = {n, "body-steps", n * 6 * bytes_of_pose, 0},
  };
}

const std::vector<std::string> for_tsan = {"pyramid_15", "hull_pit_2000"};

Scenes scenes_of_runs() {
  Scenes scenes = scenes_of_all({}, {});
  scenes.verify = {"four_bodies", "degenerate", "assorted", "soup_10", "castle_hit"};
  return scenes;
}

const Register step{
    {.name = "rigid/step",
     .place = 18,
     .serial_forms = {"original", "batches", "batches_kept", "blocks"},
     .forms = {
         {.name = "original",
          .make = [](const std::string& path) { return step_case(path, serial::step_original, openmp::step_original); },
          .scenes = scenes_of_all(settled, for_tsan)},
         {.name = "batches",
          .make = [](const std::string& path) { return step_case(path, serial::step_batches, openmp::step_batches); },
          .scenes = and_more(scenes_of_all(and_castle, for_tsan), "castles_4")},
         {.name = "batches_kept",
          .make =
              [](const std::string& path) {
                return step_case(path, serial::step_batches_kept, openmp::step_batches_kept, true);
              },
          .scenes = with_hulls_at_rest(settled, for_tsan)},
         {.name = "blocks",
          .make = [](const std::string& path) { return step_case(path, serial::step_blocks, openmp::step_blocks); },
          .scenes = and_more(scenes_of_all(and_castle, for_tsan), "castles_4")},
         {.name = "batches_run",
          .make = [](const std::string& path) { return run_case(path, serial::step_batches, openmp::step_batches); },
          .scenes = scenes_of_runs(),
          .covered_by = "batches"},
         {.name = "blocks_run",
          .make = [](const std::string& path) { return run_case(path, serial::step_blocks, openmp::step_blocks); },
          .scenes = scenes_of_runs(),
          .covered_by = "blocks"},
         {.name = "batches_kept_run",
          .make =
              [](const std::string& path) {
                return run_case(path, serial::step_batches_kept, openmp::step_batches_kept);
              },
          .scenes = {.verify = {"degenerate", "soup_10", "hull_pit_2000"}, .more = {}, .bench = {}, .tsan = {}},
          .covered_by = "batches_kept"}}}};

}  // namespace
}  // namespace lockstep::verify::rigid_step
