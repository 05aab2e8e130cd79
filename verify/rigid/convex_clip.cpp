// The rows and benchmarks of the points of convex pairs: bitwise with the serial twin.
#include "verify/rigid/narrow_inputs.h"

namespace lockstep::verify::rigid_convex_clip {
namespace {

using namespace rigid;
using namespace rigid_inputs;

Case convex_clip_case(const std::string& path) {
  const auto in = inputs(path);
  const SharedPairs pairs = convex_pairs(*in);
  Distances known = serial_distances(*in, *pairs, true);
  const auto axes = std::make_shared<std::vector<SeparatingAxis<float>>>(pairs->size());
  serial::convex_axes(in->placed(), *pairs, known.simplex, known.closest.span(), in->margin(), *axes);
  const auto with = [=](ConvexClip<float>* convex_clip) {
    return [=](Manifolds& m) { convex_clip(in->placed(), *pairs, *axes, in->margin(), m.span()); };
  };
  const double n = static_cast<double>(pairs->size());
  return make_case<Manifolds>({
      .start = poisoned<Manifold<float>>(pairs->size()),
      .serial = with(serial::convex_clip),
      .best_serial = nullptr,
      .openmp = with(openmp::convex_clip),
      .compare = nullptr,
      .work = {n, "pairs", n * (2 * bytes_of_pose + sizeof(SeparatingAxis<float>) + bytes_of_manifold), n * 500},
  });
}

const Register convex_clip{
    {.name = "rigid/convex_clip", .place = 11, .forms = {{.make = convex_clip_case, .scenes = hull_scenes()}}}};

}  // namespace
}  // namespace lockstep::verify::rigid_convex_clip
