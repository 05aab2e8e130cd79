// The rows and benchmarks of the uniform grid: pairs bitwise with the serial twin's.
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

Case grid_case(const std::string& path) {
  const auto in = inputs(path);
  const auto with = [in](GridPairs<float>* find) {
    return [in, find](Found& s) { find(in->now.bounds, in->group(), s.pairs); };
  };
  const double n = in->now.bounds.count, found = static_cast<double>(in->now.bounded.size());
  return make_case<Found>({
      .start = std::make_shared<const Found>(Found{{{0, 0}}}),  // which must be emptied first
      .serial = with(serial::grid),
      .best_serial = nullptr,
      .openmp = with(openmp::grid),
      .compare = nullptr,
      .work = {n, "boxes", n * bytes_of_box + found * sizeof(Pair), found * 6},
  });
}

const Register grid{{.name = "rigid/grid",
                     .place = 4,
                     .forms = {{.make = grid_case, .scenes = scenes_of_all(of_many_bodies)}}}};

}  // namespace
}  // namespace lockstep::verify
