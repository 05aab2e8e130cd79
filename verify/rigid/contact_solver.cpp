// The rows and benchmarks of the contact solver: bitwise with the serial form of the same order.
//
// The form `batches_for_original` measures what the order itself costs: how many sweeps in batches leave no more of the
// residual than the original order leaves.
#include "common/rigid/contact_solver.h"

#include <bit>
#include <cstdio>
#include <tuple>

#include "common/rigid/match_contacts.h"
#include "verify/rigid/inputs.h"
#include "verify/rigid/run.h"
#include "verify/twin.h"

namespace lockstep::verify::rigid_contact_solver {
namespace {

using namespace rigid;
using namespace rigid_inputs;

// The input and output of the solver.
struct Solved {
  Bodies<float> bodies;
  Array<Impulses<float>> impulses;
  Array<Motion<float>> moving;
};
template <Same<Solved> S, class F>
void for_each_array(S& s, const F& f) {
  for_each_array(s.bodies, f);
  f("impulses", s.impulses, s.impulses.size()), f("moving", s.moving, s.bodies.count);
}

Solved solver_start(const Inputs& in) {
  Solved start{in.world.bodies, Array<Impulses<float>>(in.now.manifolds.size()), in.last.moving};
  serial::match_contacts(in.last.manifolds, in.last.impulses, in.now.manifolds, start.impulses);
  return start;
}

std::vector<int> sizes_of(const Batches& batches) {
  std::vector<int> sizes(batches.count());
  for (int k = 0; k < batches.count(); ++k) sizes[k] = batches.begin[k + 1] - batches.begin[k];
  return sizes;
}

using Change = std::function<void(Solved&)>;
Change original(std::shared_ptr<const Inputs> in, ContactSolverOriginal<float>* solve) {
  return [=](Solved& s) { solve(in->settings.solver, in->now.manifolds, in->body(), s.bodies, s.impulses, s.moving); };
}
Change batched(std::shared_ptr<const Inputs> in, ContactSolverBatches<float>* solve) {
  return [=](Solved& s) {
    solve(in->settings.solver, in->now.manifolds, in->body(), in->now.batches, s.bodies, s.impulses, s.moving);
  };
}

Case solver_case(const std::string& path, bool reordered) {
  const auto in = inputs(path);
  const double rows = rows_of(*in), contacts = static_cast<double>(in->now.manifolds.size());
  const Change serial_original = original(in, serial::contact_solver_original);
  return make_case<Solved>({
      .start = std::make_shared<const Solved>(solver_start(*in)),
      .serial = reordered ? batched(in, serial::contact_solver_batches) : serial_original,
      .best_serial = reordered ? serial_original : nullptr,
      .openmp = reordered ? batched(in, openmp::contact_solver_batches) : original(in, openmp::contact_solver_original),
      .compare = nullptr,
      .work = {rows, "rows", contacts * (bytes_of_manifold + 2 * sizeof(Impulses<float>)), rows * 75,
               reordered ? lanes_in_use(sizes_of(in->now.batches)) : 0},
  });
}

// Solves the same contacts in another order: how many sweeps leave no more of the residual than ten sweeps of the
// original order do.
Case convergence_case(const std::string& path) {
  struct State {
    std::shared_ptr<const Inputs> in;
    Solved start;
    World<float> before;
    double target = 0, left = 0;
    int sweeps = 0;
  };
  const auto s = std::make_shared<State>(State{inputs(path), {}, {}, 0, 0, 0});
  s->start = solver_start(*s->in);
  s->before = s->in->world;
  s->before.bodies = s->start.bodies;
  for (Impulses<float>& impulses : s->start.impulses) impulses = {};  // cold: a warm start has little left to find
  constexpr int original_sweeps = 10, most_sweeps = 10 * original_sweeps;
  const auto residual_after = [s](int sweeps, bool reordered) {
    Solved solved = s->start;
    SolverSettings settings = s->in->settings.solver;
    settings.substeps = 1, settings.biased_sweeps = 0, settings.relax_sweeps = sweeps;
    const auto& [manifolds, batches] = std::tie(s->in->now.manifolds, s->in->now.batches);
    if (reordered)
      openmp::contact_solver_batches(settings, manifolds, s->in->body(), batches, solved.bodies, solved.impulses,
                                     solved.moving);
    else
      serial::contact_solver_original(settings, manifolds, s->in->body(), solved.bodies, solved.impulses,
                                      solved.moving);
    return residual(settings, manifolds, s->in->body(), s->before, solved.impulses);
  };
  s->target = residual_after(original_sweeps, false);
  for (s->sweeps = 1; s->sweeps < most_sweeps && residual_after(s->sweeps, true) > s->target; ++s->sweeps) {
  }
  const double n = static_cast<double>(s->in->now.manifolds.size());
  return {
      .reset = [] {},
      .serial = [residual_after] { residual_after(original_sweeps, false); },
      .best_serial = nullptr,
      .openmp = [s, residual_after] { s->left = residual_after(s->sweeps, true); },
      .judge =
          [s] {
            char text[120];
            std::snprintf(text, sizeof text, "%d sweeps in batches for %d in the original order: %.2f times", s->sweeps,
                          original_sweeps, double(s->sweeps) / original_sweeps);
            return Judgement{.verdict = Verdict::converged,
                             .passed = s->left <= s->target,
                             .error = s->left,
                             .bound = s->target,
                             .worst_at = text};
          },
      .hash = [s] { return std::bit_cast<std::uint64_t>(s->left); },
      .work = {n, "contacts", n * bytes_of_manifold, 0},
  };
}

const Register contact_solver{
    {.name = "rigid/contact_solver",
     .place = 15,
     .serial_forms = {"original", "batches"},
     .forms = {{.name = "original",
                .make = [](const std::string& path) { return solver_case(path, false); },
                .scenes = scenes_of_all(settled, {"pyramid_15", "hull_pit_2000"})},
               {.name = "batches",
                .make = [](const std::string& path) { return solver_case(path, true); },
                .scenes = and_more(scenes_of_all(and_castle, {"pyramid_15", "hull_pit_2000"}), "castles_4")},
               {.name = "batches_for_original",
                .make = convergence_case,
                .scenes = {.verify = {"four_bodies", "castle"}, .more = settled, .bench = {}, .tsan = {}},
                .covered_by = "batches"}}}};

}  // namespace
}  // namespace lockstep::verify::rigid_contact_solver
