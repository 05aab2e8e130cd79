// Impulses against impacts, as the verifier and the benchmark see them: bitwise with the serial twin of the same order.
//
// What an order costs is asked in forms of their own, `batches_for_original` and `jacobi_for_original`: how many rounds
// it takes to leave no more approach than ten rounds of the original order leave.
#include "common/production_cloth/impulses.h"

#include <cstdio>

#include "verify/production_cloth/contact_inputs.h"
#include "verify/twin.h"

namespace lockstep::production_cloth {

struct Stopped {
  Vectors<float> velocity;
};
template <Same<Stopped> S, class F>
void for_each_array(S& s, const F& f) {
  f("velocity", s.velocity, s.velocity.x.size());
}

}  // namespace lockstep::production_cloth

namespace lockstep::verify::production_cloth_impulses {
namespace {

using namespace production_cloth;
using namespace production_cloth_inputs;

using Order = Impulses<float>;

Case make(const std::string& path, Order* serial_form, Order* openmp_form, bool in_batches) {
  const auto in = contact_inputs(path);
  const auto run = [in](Order* impulses) {
    return [=](Stopped& s) {
      impulses(in->nearby, static_cast<float>(in->scene->contact.friction), in->inverse_mass, s.velocity);
    };
  };
  return make_case<Stopped>({
      .start = std::make_shared<const Stopped>(Stopped{in->velocity}),
      .serial = run(serial_form),
      .best_serial = run(serial::impulses_original),
      .openmp = run(openmp_form),
      .compare = [](const Stopped& openmp,
                    const Stopped& serial) { return bitwise(openmp, serial, of_element("vertex")); },
      .work = work_of_contacts(*in, in_batches ? lane_use_of_batches(*in) : 0),
  });
}

// Rounds without friction, until approach_of is at most `enough`, or `most` of them. Returns how many; leaves the
// approach in `left`.
int rounds(const ContactInputs& in, Order* impulses, int most, double enough, double& left) {
  Vectors<float> velocity = in.velocity;
  left = approach_of(in.nearby, velocity);
  int round = 0;
  for (; round < most && left > enough; ++round) {
    impulses(in.nearby, 0, in.inverse_mass, velocity);
    left = approach_of(in.nearby, velocity);
  }
  return round;
}

Case convergence_case(const std::string& path, Order* openmp_form) {
  constexpr int original_rounds = 10, most_times = 20;
  struct State {
    std::shared_ptr<const ContactInputs> in;
    double target = 0, left = 0;
    int needed = 0;
  };
  const auto s = std::make_shared<State>(State{.in = contact_inputs(path)});
  rounds(*s->in, serial::impulses_original, original_rounds, 0, s->target);
  return {
      .reset = [] {},
      .serial =
          [s] {
            double left;
            rounds(*s->in, serial::impulses_original, original_rounds, 0, left);
          },
      .best_serial = nullptr,
      .openmp =
          [s, openmp_form] {
            s->needed = rounds(*s->in, openmp_form, most_times * original_rounds, s->target, s->left);
          },
      .judge =
          [s] {
            char text[120];
            std::snprintf(text, sizeof text, "%d rounds for the original order's %d", s->needed, original_rounds);
            return Judgement{.verdict = Verdict::converged,
                             .passed = s->left <= s->target,
                             .error = s->left,
                             .bound = s->target,
                             .worst_at = text};
          },
      .hash = [s] { return hash_bytes(std::span<const double>(&s->left, 1)); },
      .work = work_of_contacts(*s->in, 0),
  };
}

Case make_batches(const std::string& path) {
  return make(path, serial::impulses_batches, openmp::impulses_batches, true);
}
Case make_jacobi(const std::string& path) {
  return make(path, serial::impulses_jacobi, openmp::impulses_jacobi, false);
}
Case make_batches_for_original(const std::string& path) { return convergence_case(path, openmp::impulses_batches); }
Case make_jacobi_for_original(const std::string& path) { return convergence_case(path, openmp::impulses_jacobi); }

const Scenes short_runs = {.verify = {"ball_and_walls", "ball_5k"}, .more = {}, .bench = {}, .tsan = {}};

const Register impulses{{.name = "production_cloth/impulses",
                         .place = 7,
                         .serial_forms = {"original", "batches", "jacobi"},
                         .forms = {{.name = "batches", .make = make_batches, .scenes = all_scenes()},
                                   {.name = "batches_for_original",
                                    .make = make_batches_for_original,
                                    .scenes = short_runs,
                                    .covered_by = "batches"},
                                   {.name = "jacobi", .make = make_jacobi, .scenes = all_scenes()},
                                   {.name = "jacobi_for_original",
                                    .make = make_jacobi_for_original,
                                    .scenes = short_runs,
                                    .covered_by = "jacobi"}}}};

}  // namespace
}  // namespace lockstep::verify::production_cloth_impulses
