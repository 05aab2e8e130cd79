// The rows and benchmarks of the contact solver: bitwise with the serial form of the same order.
//
// The forms `batches_for_original` and `blocks_for_original` measure what the order itself costs: how many sweeps in it
// leave no more of the residual than the original order leaves.
#include "common/rigid/contact_solver.h"

#include <bit>
#include <cstdio>
#include <functional>
#include <memory>

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

Solved solver_start(const Inputs& in) { return {in.world.bodies, warm_start(in), in.last.moving}; }

// Of parts that begin at `begin`, whose last entry is the end.
std::vector<int> sizes_of(const std::vector<std::int32_t>& begin) {
  std::vector<int> sizes;
  for (std::size_t k = 1; k < begin.size(); ++k) sizes.push_back(begin[k] - begin[k - 1]);
  return sizes;
}

using Change = std::function<void(Solved&)>;
Change original(std::shared_ptr<const Inputs> in, ContactSolverOriginal<float>* solve) {
  return [=](Solved& s) { solve(in->settings.solver, in->now.manifolds, in->body(), s.bodies, s.impulses, s.moving); };
}
// `order` is the batches or the blocks of the inputs.
template <class Order>
Change reordered(std::shared_ptr<const Inputs> in, const Order& order, ContactSolverReordered<float, Order>* solve) {
  return [in, &order, solve](Solved& s) {
    solve(in->settings.solver, in->now.manifolds, in->body(), order, s.bodies, s.impulses, s.moving);
  };
}

Case solver_case(const Inputs& in, const Change& serial, const Change& best_serial, const Change& openmp,
                 double lanes_in_use) {
  const double contacts = static_cast<double>(in.now.manifolds.size());
  return make_case<Solved>({
      .start = std::make_shared<const Solved>(solver_start(in)),
      .serial = serial,
      .best_serial = best_serial,
      .openmp = openmp,
      .compare = nullptr,
      .work = {rows_of(in), "rows", contacts * (bytes_of_manifold + 2 * sizeof(Impulses<float>)), rows_of(in) * 75,
               lanes_in_use},
  });
}

Case original_case(const std::string& path) {
  const auto in = inputs(path);
  return solver_case(*in, original(in, serial::contact_solver_original), nullptr,
                     original(in, openmp::contact_solver_original), 0);
}

Case batches_case(const std::string& path) {
  const auto in = inputs(path);
  return solver_case(*in, reordered(in, in->now.batches, serial::contact_solver_batches),
                     original(in, serial::contact_solver_original),
                     reordered(in, in->now.batches, openmp::contact_solver_batches),
                     lanes_in_use(sizes_of(in->now.batches.begin)));
}

Case blocks_case(const std::string& path) {
  const auto in = inputs(path);
  return solver_case(
      *in, reordered(in, in->now.blocks, serial::contact_solver_blocks), original(in, serial::contact_solver_original),
      reordered(in, in->now.blocks, openmp::contact_solver_blocks), lanes_in_use(sizes_of(in->now.blocks.groups)));
}

using SolveInOrder = std::function<void(const Inputs& in, const SolverSettings& settings, Solved& solved)>;

// Solves the same contacts in another order: how many sweeps leave no more of the residual than ten sweeps of the
// original order do.
Case convergence_case(const std::string& path, const char* order, const SolveInOrder& solve_in_order) {
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
  const auto residual_after = [s, solve_in_order](int sweeps, bool reordered) {
    Solved solved = s->start;
    SolverSettings settings = s->in->settings.solver;
    settings.substeps = 1, settings.biased_sweeps = 0, settings.relax_sweeps = sweeps;
    const Array<Manifold<float>>& manifolds = s->in->now.manifolds;
    if (reordered)
      solve_in_order(*s->in, settings, solved);
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
          [s, order] {
            char text[120];
            std::snprintf(text, sizeof text, "%d sweeps in %s for %d in the original order: %.2f times", s->sweeps,
                          order, original_sweeps, double(s->sweeps) / original_sweeps);
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

Case batches_for_original_case(const std::string& path) {
  return convergence_case(path, "batches", [](const Inputs& in, const SolverSettings& settings, Solved& s) {
    openmp::contact_solver_batches(settings, in.now.manifolds, in.body(), in.now.batches, s.bodies, s.impulses,
                                   s.moving);
  });
}

Case blocks_for_original_case(const std::string& path) {
  return convergence_case(path, "blocks", [](const Inputs& in, const SolverSettings& settings, Solved& s) {
    openmp::contact_solver_blocks(settings, in.now.manifolds, in.body(), in.now.blocks, s.bodies, s.impulses, s.moving);
  });
}

const std::vector<std::string> for_tsan = {"pyramid_15", "hull_pit_2000"};
const Scenes of_convergence = {.verify = {"four_bodies", "castle"}, .more = settled, .bench = {}, .tsan = {}};

const Register contact_solver{
    {.name = "rigid/contact_solver",
     .place = 16,
     .serial_forms = {"original", "batches", "blocks"},
     .forms = {
         {.name = "original", .make = original_case, .scenes = scenes_of_all(settled, for_tsan)},
         {.name = "batches",
          .make = batches_case,
          .scenes = and_more(scenes_of_all(and_castle, for_tsan), "castles_4")},
         {.name = "blocks", .make = blocks_case, .scenes = and_more(scenes_of_all(and_castle, for_tsan), "castles_4")},
         {.name = "batches_for_original",
          .make = batches_for_original_case,
          .scenes = of_convergence,
          .covered_by = "batches"},
         {.name = "blocks_for_original",
          .make = blocks_for_original_case,
          .scenes = of_convergence,
          .covered_by = "blocks"}}}};

}  // namespace
}  // namespace lockstep::verify::rigid_contact_solver
