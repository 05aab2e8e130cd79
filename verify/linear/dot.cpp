// Dot products, as the verifier and the benchmark see them: bitwise.
#include "common/linear/dot.h"

#include "verify/linear/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify {
namespace {

using namespace linear;
using namespace linear_inputs;

Case make_dot(const std::string& path) {
  const auto in = inputs(path);
  const std::size_t n = std::min(in->scene.b.size(), in->x.size());
  const auto x = std::span<const float>(in->scene.b).first(n), y = std::span<const float>(in->x).first(n);
  return make_case<State>({
      .start = std::make_shared<const State>(State{{}, {}, {unwritten}}),
      .serial = [in, x, y](State& s) { s.number[0] = serial::dot(x, y); },
      .best_serial = nullptr,
      .openmp = [in, x, y](State& s) { s.number[0] = openmp::dot(x, y); },
      .compare = nullptr,
      .work = {double(n), "elements", 8. * double(n), 2. * double(n)},
  });
}

const Scenes scenes = {.verify = {"poisson_64", "poisson_32", "file_truss", "file_general"},
                       .more = {"poisson_128"},
                       .bench = {"poisson_128"},
                       .tsan = {"poisson_32"}};

const Register dot{{.name = "linear/dot", .place = 1, .forms = {{.make = make_dot, .scenes = scenes}}}};

}  // namespace
}  // namespace lockstep::verify
