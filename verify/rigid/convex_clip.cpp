// The rows and benchmarks of the points of convex pairs: bitwise with the serial twin.
#include <algorithm>
#include <cmath>
#include <vector>

#include "common/rigid/clip_faces.h"
#include "verify/rigid/narrow_inputs.h"

namespace lockstep::verify::rigid_convex_clip {
namespace {

using namespace rigid;
using namespace rigid_inputs;

// How full the lanes are when sixteen pairs that are near clip each edge of one face by each edge of the other. A pair
// waits where its faces have fewer corners than the largest of the sixteen. A pair is not clipped if its axis is not
// the normal of a face.
double lane_use(const Placed<float>& placed, std::span<const Pair> pairs, std::span<const SeparatingAxis<float>> axes) {
  const auto corners = [&](int collider, int face) {
    const int hull = placed.colliders.hull[collider];
    if (face < 0) return placed.hulls.vertices(hull);
    const auto first = placed.hulls.first_corner.begin() + placed.hulls.first_face[hull] + face;
    return first[1] - first[0];
  };
  double used = 0, there = 0;
  int together = 0, most_reference = 0, most_incident = 0;
  const auto close = [&] {
    there += double(lanes) * most_reference * most_incident;
    together = most_reference = most_incident = 0;
  };
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const SeparatingAxis<float>& axis = axes[k];
    if (!std::isfinite(axis.separation)) continue;
    if (std::max(axis.cosine_a, axis.cosine_b) > least_cosine) {
      const int a = corners(pairs[k].a, axis.face_a), b = corners(pairs[k].b, axis.face_b);
      const bool of_b = axis.cosine_b - preference > axis.cosine_a;
      used += double(a) * b;
      most_reference = std::max(most_reference, of_b ? b : a), most_incident = std::max(most_incident, of_b ? a : b);
    }
    if (++together == lanes) close();
  }
  close();
  return there > 0 ? used / there : 0;
}

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
      .work = {n, "pairs", n * (2 * bytes_of_pose + sizeof(SeparatingAxis<float>) + bytes_of_manifold), n * 500,
               lane_use(in->placed(), *pairs, *axes)},
  });
}

const Register convex_clip{
    {.name = "rigid/convex_clip", .place = 11, .forms = {{.make = convex_clip_case, .scenes = hull_scenes()}}}};

}  // namespace
}  // namespace lockstep::verify::rigid_convex_clip
