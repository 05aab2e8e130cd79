// The rows and benchmarks of the narrow phase: bitwise with the serial twin.
#include "verify/rigid/narrow_inputs.h"

namespace lockstep::verify::rigid_narrow_phase {
namespace {

using namespace rigid;
using namespace rigid_inputs;

struct Found {
  NarrowPhaseState state;
  Array<Manifold<float>> manifolds;
};
template <Same<Found> S, class F>
void for_each_array(S& s, const F& f) {
  f("manifolds", s.manifolds, s.manifolds.size()), f("state.pairs", s.state.pairs, s.state.pairs.size());
  f("state.simplex", s.state.simplex, s.state.simplex.size());
}

Case narrow_phase_case(const std::string& path) {
  const auto in = inputs(path);
  const auto with = [in](NarrowPhase<float>* narrow_phase) {
    return
        [in, narrow_phase](Found& s) { narrow_phase(in->placed(), in->now.pairs, in->margin(), s.state, s.manifolds); };
  };
  const double n = static_cast<double>(in->now.pairs.size());
  return make_case<Found>({
      .start = std::make_shared<const Found>(Found{in->last.narrow_phase, in->last.manifolds}),
      .serial = with(serial::narrow_phase),
      .best_serial = nullptr,
      .openmp = with(openmp::narrow_phase),
      .compare = nullptr,
      .work = {n, "pairs", n * (2 * bytes_of_pose + bytes_of_manifold), n * 500},
  });
}

const Register narrow_phase{{.name = "rigid/narrow_phase",
                             .place = 12,
                             .forms = {{.make = narrow_phase_case, .scenes = scenes_of_all(settled)}}}};

}  // namespace
}  // namespace lockstep::verify::rigid_narrow_phase
