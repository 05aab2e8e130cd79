// The solve of a step of Newton's method, as the verifier and the benchmark see it: bitwise with the serial twin,
// iteration by iteration, and a true residual within what rounding explains.
//
// `block_jacobi_for_plain` asks what the preconditioner is worth: iterations, against the serial form without one.
#include "common/production_face/solve.h"

#include <cmath>
#include <cstdio>

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

namespace lockstep::verify {
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
// writes, K apart: the product two vectors, x . K x two, M^-1 r four, r . z two, x and p five, r three.
Work work_of(const Problem& problem, int iterations, bool preconditioned) {
  const double rows = 3. * problem.rows.rows, blocks = double(problem.rows.column.size());
  return {double(problem.free_nodes) * iterations, "nodes",
          iterations * (linear::bytes_of(problem.sliced) + 4 * rows * (preconditioned ? 18 : 16)),
          iterations * (18 * blocks + (preconditioned ? 17 : 12) * rows),
          double(problem.rows.column.size()) / double(problem.sliced.column.size())};
}

using SerialSolve = Solve<linear::BlockRows<float>, float>;
using OpenmpSolve = Solve<linear::SlicedBlockRows, float>;

Case make(const std::string& path, SerialSolve* serial, OpenmpSolve* openmp, bool preconditioned,
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
      .work = work_of(*in, solution.iterations, preconditioned),
  });
}

Judgement same_solve(const Solved& openmp, const Solved& serial) { return bitwise(openmp, serial); }

// Another preconditioner, and so another number of iterations.
Judgement same_answer(const Solved& openmp, const Solved&) {
  return {.verdict = Verdict::converged, .error = openmp.number[1], .bound = stop.tolerance, .worst_at = ""};
}

Case make_plain(const std::string& path) {
  return make(path, serial::solve_plain, openmp::solve_plain, false, same_solve);
}
Case make_block_jacobi(const std::string& path) {
  return make(path, serial::solve_block_jacobi, openmp::solve_block_jacobi, true, same_solve);
}
Case make_block_jacobi_for_plain(const std::string& path) {
  return make(path, serial::solve_plain, openmp::solve_block_jacobi, true, same_answer);
}

// Without a preconditioner, `block_370k` takes too many iterations to be timed, and the crushed tetrahedra of
// `inside_out` are not solved at all.
const Scenes plain_scenes = {.verify = {"bar_shaken", "twelve"},
                             .more = {"block_370k"},
                             .bench = {"bar_shaken"},
                             .tsan = {"bar_shaken", "twelve"}};

const Register solve{
    {.name = "production_face/solve",
     .place = 4,
     .serial_forms = {"plain", "block_jacobi"},
     .forms = {{.name = "plain", .make = make_plain, .scenes = plain_scenes},
               {.name = "block_jacobi", .make = make_block_jacobi, .scenes = body_scenes()},
               {.name = "block_jacobi_for_plain",
                .make = make_block_jacobi_for_plain,
                .scenes = {.verify = {"bar_shaken", "twelve"}, .more = {"block_370k"}, .bench = {}, .tsan = {}},
                .covered_by = "block_jacobi"}}}};

}  // namespace
}  // namespace lockstep::verify
