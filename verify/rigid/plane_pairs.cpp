// The rows and benchmarks of pairs with planes: bitwise with the serial twin.
#include "common/rigid/broad_phase.h"
#include "verify/rigid/found_pairs.h"

namespace lockstep::verify::rigid_plane_pairs {
namespace {

using namespace rigid;
using namespace rigid_inputs;

Case plane_pairs_case(const std::string& path) {
  const auto in = inputs(path);
  const auto with = [&](PlanePairs<float>* find) {
    return [in, find](Pairs& pairs) { find(in->world.colliders, in->placed().pose, in->now.bounds, pairs); };
  };
  return pairs_case(*in, with(serial::plane_pairs), with(openmp::plane_pairs));
}

const Register plane_pairs{{.name = "rigid/plane_pairs",
                            .place = 5,
                            .forms = {{.make = plane_pairs_case, .scenes = scenes_of_all(of_many_bodies)}}}};

}  // namespace
}  // namespace lockstep::verify::rigid_plane_pairs
