// Forces on nodes, as the verifier and the benchmark see them: bitwise with the serial twin where a node adds up its
// parts; under locks, within the rounding of sums in any order. notes/production_face.md derives the bound.
#include "common/production_face/forces.h"

#include <cmath>
#include <limits>

#include "verify/production_face/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::production_face_forces {
namespace {

using namespace production_face;
using namespace production_face_inputs;

struct State {
  Array<float> force;
};

template <Same<State> S, class F>
void for_each_array(S& state, const F& f) {
  f("force", state.force, state.force.size());
}

// The exact sums of the parts, which are the same floats in all versions, and how far a float sum may be from them.
struct Sums {
  std::vector<double> exact, rounding;
};

Sums sums(const Body<float>& body, const Strained<float>& strained) {
  Sums s = {std::vector<double>(3 * body.nodes), std::vector<double>(3 * body.nodes)};
  for (int t = 0; t < body.tetrahedra; ++t) {
    const auto field = [&](const Blocked<float>& array, int k) { return array.at(t, k); };
    const Parts<float> part = element_forces<float>(body, strained, field);
    for (int a = 0; a < 4; ++a) {
      const int node = body.corner.at(t, a), terms = body.first_corner[node + 1] - body.first_corner[node];
      const float components[] = {part.of[a].x, part.of[a].y, part.of[a].z};
      for (int c = 0; c < 3; ++c) {
        s.exact[3 * node + c] += components[c];
        s.rounding[3 * node + c] += terms * unit_roundoff * std::abs(components[c]);
      }
    }
  }
  return s;
}

// A tetrahedron reads its corners, nine gradients, a volume and nine stresses, and takes about 75 operations.
Case make(const std::string& path, bool locks) {
  const auto in = inputs(path);
  const auto state = strained(path);
  const auto in_waves = std::make_shared<const Waves>(waves(in->body));
  const auto parts = poisoned_parts(in->body);
  State start = {Array<float>(3 * static_cast<std::size_t>(in->body.nodes))};
  poison(start);
  const double n = in->body.tetrahedra;
  const auto expected = std::make_shared<const Sums>(locks ? sums(in->body, *state) : Sums{});
  const auto bounded = [expected](const State& openmp, const State& serial) {
    Judgement judgement{.verdict = Verdict::bounded, .worst_at = ""};
    within_bound(judgement, openmp.force, serial.force, expected->exact, expected->rounding,
                 [](std::size_t k) { return "xyz"[k % 3] + (" of node " + std::to_string(k / 3)); });
    return judgement;
  };
  return make_case<State>({
      .start = std::make_shared<const State>(start),
      .serial = [=](State& s) { serial::forces(in->body, *state, s.force); },
      .best_serial = nullptr,
      .openmp =
          [=](State& s) {
            if (locks)
              openmp::forces_locks(in->body, *state, s.force);
            else
              openmp::forces(in->body, *state, *in_waves, *parts, s.force);
          },
      .compare = locks ? bounded : bitwise_and_poison<State>(parts),
      .work = {n, "tetrahedra", 4 * (23 * n + 3. * in->body.nodes), 75 * n, n / in->body.padded_tetrahedra()},
  });
}

const Register forces{
    {.name = "production_face/forces",
     .place = 2,
     .forms = {
         {.name = "gather", .make = [](const std::string& path) { return make(path, false); }, .scenes = body_scenes()},
         {.name = "locks",
          .make = [](const std::string& path) { return make(path, true); },
          .scenes = body_scenes(),
          .order_dependent = true}}}};

}  // namespace
}  // namespace lockstep::verify::production_face_forces
