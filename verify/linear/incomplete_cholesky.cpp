// Incomplete Cholesky, as the verifier and the benchmark see it: bitwise with the serial text, both on the matrix that
// is numbered by its levels. The best serial form is the serial text on the matrix as it came.
#include "common/linear/incomplete_cholesky.h"

#include "verify/linear/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::linear_incomplete_cholesky {
namespace {

using namespace linear;
using namespace linear_inputs;

struct Factors {
  Array<float> lower, upper, inverse;
};
template <Same<Factors> F, class G>
void for_each_array(F& f, const G& g) {
  g("lower", f.lower, f.lower.size());
  g("upper", f.upper, f.upper.size());
  g("inverse", f.inverse, f.inverse.size());
}
Factors values_of(Factor<float>&& f) {
  return {std::move(f.lower.value), std::move(f.upper.value), std::move(f.inverse)};
}

Case make_factor(const std::string& path) {
  const auto in = factored(path);
  const auto scene = inputs(path);
  const Modification modification = scene->scene.modification;
  const double entries = double(in->rows.value.size()), rows = in->rows.rows;
  return make_case<Factors>({
      .start = std::make_shared<const Factors>(),
      .serial = [=](Factors& f) { f = values_of(serial::incomplete_cholesky(in->rows, modification)); },
      .best_serial = [=](Factors& f) { f = values_of(serial::incomplete_cholesky(scene->scene.rows, modification)); },
      .openmp = [=](Factors& f) { f = values_of(openmp::incomplete_cholesky(in->rows, in->levels, modification)); },
      .compare = nullptr,
      // The factor is written, and read once while it is made.
      .work = {rows, "rows", 24 * entries + 8 * rows, 4 * entries},
  });
}

Case make_solve(const std::string& path) {
  const auto in = factored(path);
  const auto scene = inputs(path);
  struct Natural {
    Factor<float> factor;
  };
  const auto natural = std::make_shared<const Natural>(
      Natural{serial::incomplete_cholesky(scene->scene.rows, scene->scene.modification)});
  const double entries = double(in->factor.lower.value.size()), rows = in->rows.rows;
  const SlicedRows& lower = in->sliced_factor.lower;
  return make_case<State>({
      .start = std::make_shared<const State>(State{{}, Array<float>(in->rows.rows, unwritten), {}}),
      .serial = [=](State& s) { serial::solve(in->factor, in->b, s.y); },
      .best_serial = [=](State& s) { serial::solve(natural->factor, scene->scene.b, s.y); },
      .openmp = [=](State& s) { openmp::solve(in->sliced_factor, in->b, s.y); },
      .compare = nullptr,
      .work = {rows, "rows", bytes_of(lower) + bytes_of(in->sliced_factor.upper) + 24 * rows, 4 * entries + 3 * rows,
               entries / (double(lower.slots.size()) * lanes)},
  });
}

const Scenes scenes = {.verify = {"poisson_64", "poisson_32", "file_truss"},
                       .more = {"poisson_128", "elasticity_24"},
                       .bench = {"poisson_128"},
                       .tsan = {"poisson_32"}};

const Register incomplete_cholesky{
    {.name = "linear/incomplete_cholesky",
     .place = 4,
     .serial_forms = {"factor", "solve"},
     .forms = {{.name = "factor", .make = make_factor, .scenes = scenes, .takes = is_solvable},
               {.name = "solve", .make = make_solve, .scenes = scenes, .takes = is_solvable}}}};

}  // namespace
}  // namespace lockstep::verify::linear_incomplete_cholesky
