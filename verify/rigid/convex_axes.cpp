// The rows and benchmarks of the axes of convex pairs: bitwise with the serial twin.
#include <cmath>
#include <vector>

#include "verify/rigid/narrow_inputs.h"

namespace lockstep::verify::rigid_convex_axes {
namespace {

using namespace rigid;
using namespace rigid_inputs;

using Axes = PerPair<SeparatingAxis<float>>;

// How full the lanes are in loops over the faces and the vertices of both cores, of pairs that are near. Loops over
// edges are not counted.
double lane_use(const Placed<float>& placed, std::span<const Pair> pairs, std::span<const SeparatingAxis<float>> axes) {
  std::vector<double> runs;
  for (std::size_t k = 0; k < pairs.size(); ++k)
    if (std::isfinite(axes[k].separation))
      for (const int collider : {pairs[k].a, pairs[k].b}) {
        const int hull = placed.colliders.hull[collider];
        runs.push_back(placed.hulls.faces(hull)), runs.push_back(placed.hulls.vertices(hull));
      }
  return lanes_in_use(runs);
}

Case convex_axes_case(const std::string& path) {
  const auto in = inputs(path);
  const SharedPairs pairs = convex_pairs(*in);
  const auto known = std::make_shared<Distances>(serial_distances(*in, *pairs, true));
  const auto with = [=](ConvexAxes<float>* convex_axes) {
    return [=](Axes& axes) {
      convex_axes(in->placed(), *pairs, known->simplex, known->closest.span(), in->margin(), axes.span());
    };
  };
  Axes there{pairs->size(), Array<SeparatingAxis<float>>(padded(pairs->size()))};
  with(serial::convex_axes)(there);
  const double n = static_cast<double>(pairs->size());
  return make_case<Axes>({
      .start = poisoned<SeparatingAxis<float>>(pairs->size()),
      .serial = with(serial::convex_axes),
      .best_serial = nullptr,
      .openmp = with(openmp::convex_axes),
      .compare = nullptr,
      .work = {n, "pairs", n * (2 * bytes_of_pose + sizeof(SeparatingAxis<float>)), n * 1500,
               lane_use(in->placed(), *pairs, there.span())},
  });
}

const Register convex_axes{
    {.name = "rigid/convex_axes", .place = 10, .forms = {{.make = convex_axes_case, .scenes = hull_scenes()}}}};

}  // namespace
}  // namespace lockstep::verify::rigid_convex_axes
