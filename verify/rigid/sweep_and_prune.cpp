// The rows and benchmarks of sweep and prune: pairs, order and axis bitwise with the serial twin.
#include <algorithm>

#include "common/rigid/broad_phase.h"
#include "common/spatial/sweep.h"
#include "verify/rigid/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::rigid_sweep_and_prune {
namespace {

using namespace rigid;
using namespace rigid_inputs;

struct Swept {
  SweepOrder state;
  Pairs pairs;
  std::vector<std::int32_t> axis;  // one element
};
template <Same<Swept> S, class F>
void for_each_array(S& s, const F& f) {
  f("pairs", s.pairs, s.pairs.size()), f("order", s.state.order, s.state.order.size());
  f("axis", s.axis, s.axis.size());
}

// How many boxes each box meets along the swept axis: its candidates, tested sixteen at once.
std::vector<int> candidates_of_sweep(const Bounds<float>& bounds, int axis) {
  const Array<float>&low = spatial::along(bounds.low, axis), &high = spatial::along(bounds.high, axis);
  std::vector<float> lows;
  for (int i = 0; i < bounds.count; ++i)
    if (bounds.bounded(i)) lows.push_back(low[i]);
  std::ranges::sort(lows);
  std::vector<int> candidates;
  for (int i = 0; i < bounds.count; ++i)
    if (bounds.bounded(i))
      candidates.push_back(
          static_cast<int>(std::ranges::upper_bound(lows, high[i]) - std::ranges::upper_bound(lows, low[i])));
  return candidates;
}

Case sweep_case(const std::string& path) {
  const auto in = inputs(path);
  const auto with = [in](SweepAndPrune<float>* find) {
    return [in, find](Swept& s) {
      find(in->now.bounds, in->group(), s.state, s.pairs);
      s.axis.assign(1, s.state.axis);
    };
  };
  Swept start, answer;
  start.state.order = {0}, start.pairs = {{0, 0}};  // which must be emptied first
  with(serial::sweep_and_prune_batch)(answer);
  const double n = in->now.bounds.count, found = static_cast<double>(in->now.bounded.size());
  return make_case<Swept>({
      .start = std::make_shared<const Swept>(std::move(start)),
      .serial = with(serial::sweep_and_prune_batch),
      .best_serial = nullptr,
      .openmp = with(openmp::sweep_and_prune_batch),
      .compare = nullptr,
      .work = {n, "boxes", n * bytes_of_box + found * sizeof(Pair), found * 6,
               lanes_in_use(candidates_of_sweep(in->now.bounds, answer.state.axis))},
  });
}

const Register sweep_and_prune{
    {.name = "rigid/sweep_and_prune",
     .place = 2,
     .serial_forms = {"batch", "incremental"},
     .forms = {{.name = "batch", .make = sweep_case, .scenes = scenes_of_all(of_many_bodies)}}}};

}  // namespace
}  // namespace lockstep::verify::rigid_sweep_and_prune
