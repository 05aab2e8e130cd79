// The rows and benchmarks of placing colliders: bitwise with the serial twin.
#include "common/rigid/place_colliders.h"

#include "verify/rigid/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::rigid_place_colliders {
namespace {

using namespace rigid;
using namespace rigid_inputs;

struct Placement {
  Array<Pose<float>> placed;
  Bounds<float> bounds;
};
template <Same<Placement> P, class F>
void for_each_array(P& p, const F& f) {
  f("placed", p.placed, p.bounds.count), f("bounds.low", p.bounds.low, p.bounds.count);
  f("bounds.high", p.bounds.high, p.bounds.count);
}

Case place_case(const std::string& path) {
  const auto in = inputs(path);
  const auto with = [in](PlaceColliders<float>* place) {
    return [in, place](Placement& p) { place(in->world, in->margin() / 2, p.placed, p.bounds); };
  };
  Placement start{in->last.placed, in->last.bounds};
  poison(start);
  const double n = in->world.colliders.count;
  return make_case<Placement>({
      .start = std::make_shared<const Placement>(std::move(start)),
      .serial = with(serial::place_colliders),
      .best_serial = nullptr,
      .openmp = with(openmp::place_colliders),
      .compare = nullptr,
      .work = {n, "colliders", n * (3 * bytes_of_pose + bytes_of_box), n * 120},
  });
}

const Register place_colliders{{.name = "rigid/place_colliders",
                                .place = 1,
                                .forms = {{.make = place_case, .scenes = scenes_of_all(of_many_bodies)}}}};

}  // namespace
}  // namespace lockstep::verify::rigid_place_colliders
