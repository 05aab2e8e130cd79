// The rows and benchmarks of the axes of convex pairs: bitwise with the serial twin.
#include "verify/rigid/narrow_inputs.h"

namespace lockstep::verify::rigid_convex_axes {
namespace {

using namespace rigid;
using namespace rigid_inputs;

using Axes = PerPair<SeparatingAxis<float>>;

Case convex_axes_case(const std::string& path) {
  const auto in = inputs(path);
  const SharedPairs pairs = convex_pairs(*in);
  const auto known = std::make_shared<Distances>(serial_distances(*in, *pairs, true));
  const auto with = [=](ConvexAxes<float>* convex_axes) {
    return [=](Axes& axes) {
      convex_axes(in->placed(), *pairs, known->simplex, known->closest.span(), in->margin(), axes.span());
    };
  };
  const double n = static_cast<double>(pairs->size());
  return make_case<Axes>({
      .start = poisoned<SeparatingAxis<float>>(pairs->size()),
      .serial = with(serial::convex_axes),
      .best_serial = nullptr,
      .openmp = with(openmp::convex_axes),
      .compare = nullptr,
      .work = {n, "pairs", n * (2 * bytes_of_pose + sizeof(SeparatingAxis<float>)), n * 1500},
  });
}

const Register convex_axes{
    {.name = "rigid/convex_axes", .place = 10, .forms = {{.make = convex_axes_case, .scenes = hull_scenes()}}}};

}  // namespace
}  // namespace lockstep::verify::rigid_convex_axes
