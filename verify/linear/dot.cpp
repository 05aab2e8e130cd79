// Dot products, as the verifier and the benchmark see them: bitwise.
#include "common/linear/dot.h"

#include <algorithm>
#include <cmath>

#include "verify/linear/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::linear_dot {
namespace {

using namespace linear;
using namespace linear_inputs;

// The scene's vectors, scaled by powers of two up to 2^30 apart: sums of their products are then not exact in double,
// and the order of additions shows.
struct Vectors {
  Array<float> x, y;
};

Vectors vectors(const Inputs& in) {
  const std::size_t n = std::min(in.scene.b.size(), in.x.size());
  Vectors v{{in.scene.b.begin(), in.scene.b.begin() + n}, {in.x.begin(), in.x.begin() + n}};
  for (std::size_t i = 0; i < n; ++i) v.x[i] = std::ldexp(v.x[i], static_cast<int>(i * 7 % 31) - 15);
  return v;
}

Case make_dot(const std::string& path) {
  const auto v = std::make_shared<const Vectors>(vectors(*inputs(path)));
  const double n = double(v->x.size());
  return make_case<State>({
      .start = std::make_shared<const State>(State{{}, {}, {unwritten}}),
      .serial =
          [v](State& s) { s.number[0] = serial::dot(std::span<const float>(v->x), std::span<const float>(v->y)); },
      .best_serial = nullptr,
      .openmp = [v](State& s) { s.number[0] = openmp::dot(v->x, v->y); },
      .compare = nullptr,
      .work = {n, "elements", 8. * n, 2. * n},
  });
}

const Scenes scenes = {.verify = {"poisson_64", "poisson_32", "file_truss", "file_general"},
                       .more = {"poisson_128"},
                       .bench = {"poisson_128"},
                       .tsan = {"poisson_32"}};

const Register dot{{.name = "linear/dot", .place = 1, .forms = {{.make = make_dot, .scenes = scenes}}}};

}  // namespace
}  // namespace lockstep::verify::linear_dot
