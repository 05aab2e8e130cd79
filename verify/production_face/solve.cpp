// The solve of a step of Newton's method, as the verifier and the benchmark see it: bitwise with the serial twin,
// iteration by iteration, and a true residual within what rounding explains.
//
// `block_jacobi_for_plain` and `multigrid_for_plain` ask what a preconditioner is worth: iterations, against the serial
// form without one. That of the second must take at most a fifth.
#include "common/production_face/solve.h"

#include <cmath>
#include <cstdio>
#include <functional>

#include "verify/production_face/inputs.h"
#include "verify/twin.h"

namespace lockstep::production_face {

// What a solve changes: x; iterations, |r| / |b| of the sum, and the true one of x.
struct Solved {
  Array<float> x;
  Array<double> number;
};
template <Same<Solved> S, class F>
void for_each_array(S& solved, const F& f) {
  f("x", solved.x, solved.x.size());
  f("number", solved.number, solved.number.size());
}

}  // namespace lockstep::production_face

namespace lockstep::verify::production_face_solve {
namespace {

using namespace production_face;
using namespace production_face_inputs;

// A thousandth: what a step of Newton's method asks for, whose next step corrects the rest.
constexpr linear::Stop stop = {.tolerance = 1e-3, .iterations = 4000};

// The residual that the rounding of x leaves beside that of the sum: u |K| |x|, of absolute values.
double attainable(const Problem& problem, const Solved& s) {
  double squares = 0, bb = 0;
  for (int i = 0; i < problem.rows.rows; ++i)
    for (int r = 0; r < 3; ++r) {
      double sum = 0;
      for (int k = problem.rows.begin[i]; k < problem.rows.begin[i + 1]; ++k)
        for (int c = 0; c < 3; ++c)
          sum += std::abs(double(problem.rows.value[9 * std::size_t(k) + 3 * r + c]) *
                          s.x[3 * std::size_t(problem.rows.column[k]) + c]);
      squares += sum * sum;
    }
  for (const float e : problem.b) bb += double(e) * e;
  return s.number[1] + unit_roundoff * std::sqrt(squares / bb);
}

// Adds to a comparison how the solve went, and asks that it converged.
void require_convergence(Judgement& judgement, const Problem& problem, const Solved& openmp) {
  if (!judgement.passed) return;
  const double bound = attainable(problem, openmp);
  char text[120];
  std::snprintf(text, sizeof text, "%.0f iterations, |r|/|b| %.2e, true %.2e of at most %.2e", openmp.number[0],
                openmp.number[1], openmp.number[2], bound);
  judgement.worst_at = text;
  judgement.passed = openmp.number[1] <= stop.tolerance && openmp.number[2] <= bound;
}

// An iteration multiplies by K and by M^-1, takes three dot products, and updates three vectors. Of what it reads and
// writes, K apart: the product two vectors, x . K x two, M^-1 r four, r . z two, x and p five, r three; with M^-1 these
// are six vectors. Multigrid multiplies by K twice more; the rest of its cycle is left out.
enum class By { nothing, blocks, levels };

Work work_of(const Problem& problem, int iterations, By by) {
  const int products = by == By::levels ? 3 : 1;
  const bool preconditioned = by != By::nothing;
  const double rows = 3. * problem.rows.rows, blocks = double(problem.rows.column.size());
  return {double(problem.free_nodes) * iterations, "nodes",
          iterations * (products * linear::bytes_of(problem.sliced) + 4 * rows * (preconditioned ? 18 : 16)),
          iterations * (products * 18 * blocks + (preconditioned ? 17 : 12) * rows),
          double(problem.rows.column.size()) / double(problem.sliced.column.size()),
          linear::bytes_of(problem.sliced) + 4 * 6 * rows};
}

using SerialSolve = std::function<Solve<linear::BlockRows<float>, float>>;
using OpenmpSolve = std::function<Solve<linear::SlicedBlockRows, float>>;
Solve<linear::BlockRows<float>, float>&serial_plain = serial::solve_plain,
                                &serial_block_jacobi = serial::solve_block_jacobi;

Case make(const std::string& path, const SerialSolve& serial, const OpenmpSolve& openmp, By by,
          Judgement (*compare)(const Solved& openmp, const Solved& serial)) {
  const auto in = problem(path);
  Solved start = {Array<float>(in->b.size()), Array<double>(3)};
  poison(start);
  const auto keep = [](Solved& s, const linear::Solution& solution) {
    s.number = {double(solution.iterations), solution.recursive_residual, solution.true_residual};
  };
  Solved solved = start;
  const linear::Solution solution = openmp(in->sliced, in->b, stop, solved.x);
  return make_case<Solved>({
      .start = std::make_shared<const Solved>(std::move(start)),
      .serial = [=](Solved& s) { keep(s, serial(in->rows, in->b, stop, s.x)); },
      .best_serial = nullptr,
      .openmp = [=](Solved& s) { keep(s, openmp(in->sliced, in->b, stop, s.x)); },
      .compare =
          [=](const Solved& openmp, const Solved& serial) {
            Judgement judgement = compare(openmp, serial);
            require_convergence(judgement, *in, openmp);
            if (judgement.verdict == Verdict::converged)
              judgement.worst_at += "; plain " + std::to_string(static_cast<int>(serial.number[0]));
            return judgement;
          },
      .work = work_of(*in, solution.iterations, by),
  });
}

Judgement same_solve(const Solved& openmp, const Solved& serial) { return bitwise(openmp, serial); }

// Another preconditioner, and so another number of iterations.
Judgement same_answer(const Solved& openmp, const Solved&) {
  return {.verdict = Verdict::converged, .error = openmp.number[1], .bound = stop.tolerance, .worst_at = ""};
}

Case make_plain(const std::string& path) {
  return make(path, serial_plain, openmp::solve_plain, By::nothing, same_solve);
}
Case make_block_jacobi(const std::string& path) {
  return make(path, serial_block_jacobi, openmp::solve_block_jacobi, By::blocks, same_solve);
}
Case make_block_jacobi_for_plain(const std::string& path) {
  return make(path, serial_plain, openmp::solve_block_jacobi, By::blocks, same_answer);
}

// Each with room of its own, which lives as long as the case.
SerialSolve serial_multigrid(const std::string& path) {
  const auto in = problem(path);
  const auto memory =
      std::make_shared<Multigrid<float, linear::BlockRows<float>>>(serial::make_multigrid(in->coarsening, in->rows));
  return [=](const auto& k, auto b, const auto& stop, auto x) {
    return serial::solve_multigrid(in->coarsening, k, b, stop, x, *memory);
  };
}
OpenmpSolve openmp_multigrid(const std::string& path) {
  const auto in = problem(path);
  const auto memory =
      std::make_shared<Multigrid<float, linear::SlicedBlockRows>>(openmp::make_multigrid(in->coarsening, in->sliced));
  return [=](const auto& k, auto b, const auto& stop, auto x) {
    return openmp::solve_multigrid(in->coarsening, k, b, stop, x, *memory);
  };
}
Case make_multigrid(const std::string& path) {
  return make(path, serial_multigrid(path), openmp_multigrid(path), By::levels, same_solve);
}

// A fifth of the iterations, too.
Judgement same_answer_sooner(const Solved& openmp, const Solved& serial) {
  Judgement judgement = same_answer(openmp, serial);
  judgement.passed = 5 * openmp.number[0] <= serial.number[0];
  return judgement;
}
Case make_multigrid_for_plain(const std::string& path) {
  return make(path, serial_plain, openmp_multigrid(path), By::levels, same_answer_sooner);
}

// Without a preconditioner, `block_370k` takes too many iterations to be timed, and the crushed tetrahedra of
// `inside_out` are not solved at all.
const Scenes plain_scenes = {.verify = {"bar_shaken", "twelve"},
                             .more = {"block_370k"},
                             .bench = {"bar_shaken"},
                             .tsan = {"bar_shaken", "twelve"}};

// Faces have more than one coarse level.
const Scenes level_scenes = {.verify = {"bar_shaken", "twelve", "inside_out", "face_6k", "face_smile"},
                             .more = {"block_370k", "face_381k"},
                             .bench = {"block_370k", "face_381k"},
                             .tsan = {"bar_shaken", "face_6k"}};

const Register solve{
    {.name = "production_face/solve",
     .place = 4,
     .serial_forms = {"plain", "block_jacobi", "multigrid"},
     .forms = {
         {.name = "plain", .make = make_plain, .scenes = plain_scenes},
         {.name = "block_jacobi", .make = make_block_jacobi, .scenes = body_scenes()},
         {.name = "block_jacobi_for_plain",
          .make = make_block_jacobi_for_plain,
          .scenes = {.verify = {"bar_shaken", "twelve"}, .more = {"block_370k"}, .bench = {}, .tsan = {}},
          .covered_by = "block_jacobi"},
         {.name = "multigrid", .make = make_multigrid, .scenes = level_scenes},
         {.name = "multigrid_for_plain",
          .make = make_multigrid_for_plain,
          .scenes = {.verify = {"bar_shaken", "face_6k"}, .more = {"face_smile", "face_381k"}, .bench = {}, .tsan = {}},
          .covered_by = "multigrid"}}}};

}  // namespace
}  // namespace lockstep::verify::production_face_solve
