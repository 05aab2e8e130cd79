// The rows and benchmarks of pairs with planes: bitwise with the serial twin.
#include "common/rigid/broad_phase.h"
#include "verify/rigid/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify {
namespace {

using namespace rigid;
using namespace rigid_inputs;

struct Found {
  Pairs pairs;
};
template <Same<Found> S, class F>
void for_each_array(S& s, const F& f) {
  f("pairs", s.pairs, s.pairs.size());
}

Case plane_pairs_case(const std::string& path) {
  const auto in = inputs(path);
  const auto with = [in](PlanePairs<float>* find) {
    return [in, find](Found& s) { find(in->world.colliders, in->placed().pose, in->now.bounds, s.pairs); };
  };
  const double n = in->now.bounds.count, found = static_cast<double>(in->now.bounded.size());
  return make_case<Found>({
      .start = std::make_shared<const Found>(Found{{{0, 0}}}),  // which must be emptied first
      .serial = with(serial::plane_pairs),
      .best_serial = nullptr,
      .openmp = with(openmp::plane_pairs),
      .compare = nullptr,
      .work = {n, "boxes", n * bytes_of_box + found * sizeof(Pair), found * 6},
  });
}

const Register plane_pairs{{.name = "rigid/plane_pairs",
                            .place = 5,
                            .forms = {{.make = plane_pairs_case, .scenes = scenes_of_all(of_many_bodies)}}}};

}  // namespace
}  // namespace lockstep::verify
