// Conjugate gradients, as the verifier and the benchmark see them: bitwise with the serial loop over the serial
// kernels, iteration by iteration, and a true residual within what rounding explains.
//
// `incomplete_cholesky` solves in the order of levels, serial and openmp alike; its best serial form is Eigen's, in
// float and in one thread. `incomplete_cholesky_for_natural` asks what that order costs: iterations, against the serial
// text in the order that the matrix came in.
#include "common/linear/conjugate_gradients.h"

// g++ 12 takes the undefined registers that its own intrinsics start from for mistakes of Eigen's (GCC bug 105593).
#ifndef __clang__
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif

#include <cmath>
#include <cstdio>
// As wherever Eigen is used here: what it inlines and how it allocates depends on this, and must not differ between
// files.
#define EIGEN_DONT_VECTORIZE
#include <eigen3/Eigen/IterativeLinearSolvers>
#include <eigen3/Eigen/SparseCore>

#include "common/linear/dot.h"
#include "common/linear/multiply.h"
#include "verify/linear/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::linear_conjugate_gradients {
namespace {

using namespace linear;
using namespace linear_inputs;

using In = std::span<const float>;
using Out = std::span<float>;

// x in State::x; in `number`: iterations, |r| / |b| and |b - A x| / |b|.
void keep(State& state, const Solution& s) {
  state.number = {double(s.iterations), s.recursive_residual, s.true_residual};
}

std::shared_ptr<const State> start(std::size_t n) {
  return std::make_shared<const State>(State{Array<float>(n, unwritten), {}, {-1, -1, -1}});
}

// The true residual that rounding allows: the recursive residual, and k updates of x and r, each wrong by at most u |A|
// |x| to first order, with |A| the infinity norm. In conjugate gradients from 0, |x| grows monotonically, so the last
// is the largest.
double attainable(const Rows<float>& a, In x, In b, const Solution& s) {
  double norm = 0;
  for (int i = 0; i < a.rows; ++i) {
    double sum = 0;
    for (int k = a.begin[i]; k < a.begin[i + 1]; ++k) sum += std::abs(a.value[k]);
    norm = std::max(norm, sum);
  }
  double xx = 0, bb = 0;
  for (const float e : x) xx += double(e) * e;
  for (const float e : b) bb += double(e) * e;
  return s.recursive_residual + s.iterations * unit_roundoff * norm * std::sqrt(xx / bb);
}

// Adds to a comparison that the solve converged, and how far: in words and, where it did not, as a failure.
void require_convergence(Judgement& judgement, const State& state, const Rows<float>& a, In b, const Stop& stop) {
  const Solution s{static_cast<int>(state.number[0]), state.number[1], state.number[2]};
  const double bound = attainable(a, state.x, b, s);
  char text[120];
  std::snprintf(text, sizeof text, "%d iterations, |r|/|b| %.2e, true %.2e of at most %.2e", s.iterations,
                s.recursive_residual, s.true_residual, bound);
  if (!judgement.passed) return;
  judgement.worst_at = text;
  judgement.passed = s.recursive_residual <= stop.tolerance && s.true_residual <= bound;
}

// An iteration multiplies by A and by M^-1, takes three dot products, and updates three vectors; of what it reads and
// writes, the matrices apart: A p and M^-1 r two vectors each, r . z two, x and p five, r three.
Work work_of(const Solution& s, double rows, double matrix_bytes, double matrix_flops) {
  return {rows * s.iterations, "rows", s.iterations * (matrix_bytes + 56 * rows),
          s.iterations * (matrix_flops + 12 * rows), 0, matrix_bytes + 4 * 5 * rows};
}

struct Twins {
  System<float> serial, openmp;
  const Rows<float>& rows;  // for the residual that rounding leaves
  In b;
  double matrix_bytes, matrix_flops;
  std::function<void(State&)> best_serial;
  std::shared_ptr<const void> kept;  // what the systems refer to
};

Case make(const Twins& twins, const Stop& stop) {
  const auto t = std::make_shared<const Twins>(twins);
  const auto first = start(t->b.size());
  State solved = *first;
  const Solution solution = openmp::conjugate_gradients(t->openmp, t->b, solved.x, stop);
  return make_case<State>({
      .start = first,
      .serial = [=](State& s) { keep(s, serial::conjugate_gradients(t->serial, t->b, s.x, stop)); },
      .best_serial = t->best_serial,
      .openmp = [=](State& s) { keep(s, openmp::conjugate_gradients(t->openmp, t->b, s.x, stop)); },
      .compare =
          [=](const State& openmp, const State& serial) {
            Judgement judgement = bitwise(openmp, serial, of_element("unknown"));
            require_convergence(judgement, openmp, t->rows, t->b, stop);
            return judgement;
          },
      .work = work_of(solution, double(t->b.size()), t->matrix_bytes, t->matrix_flops),
  });
}

Case make_jacobi(const std::string& path) {
  const auto in = inputs(path);
  struct Diagonal {
    Rows<float> rows;
    SlicedRows sliced;
  };
  const Rows<float> inverse = inverse_diagonal(in->scene.rows);
  const auto d = std::make_shared<const Diagonal>(Diagonal{inverse, slice(inverse)});
  const auto residual = [in](In b, In x) { return residual_norm(in->scene.rows, b, x); };
  return make({.serial = {[in](In x, Out y) { return serial::multiply_and_dot(in->scene.rows, x, y); },
                          [d](In x, Out y) { return serial::multiply(d->rows, x, y), serial::dot(x, In(y)); },
                          residual},
               .openmp = {[in](In x, Out y) { return openmp::multiply_and_dot(in->sliced, x, y); },
                          [d](In x, Out y) { return openmp::multiply(d->sliced, x, y), openmp::dot(x, y); },
                          residual},
               .rows = in->scene.rows,
               .b = in->scene.b,
               .matrix_bytes = bytes_of(in->sliced) + bytes_of(d->sliced),
               .matrix_flops = 2. * double(in->scene.rows.value.size() + d->rows.value.size()),
               .best_serial = nullptr,
               .kept = in},
              in->scene.stop);
}

Case make_block_jacobi(const std::string& path) {
  const auto in = inputs(path);
  struct Diagonal {
    BlockRows<float> rows;
    SlicedBlockRows sliced;
  };
  const BlockRows<float> inverse = inverse_diagonal(in->scene.blocks);
  const auto d = std::make_shared<const Diagonal>(Diagonal{inverse, slice(inverse)});
  const auto residual = [in](In b, In x) { return residual_norm(in->scene.blocks, b, x); };
  return make({.serial = {[in](In x, Out y) {
                            serial::multiply(in->scene.blocks, x, y);
                            return serial::dot(x, In(y));
                          },
                          [d](In x, Out y) { return serial::multiply(d->rows, x, y), serial::dot(x, In(y)); },
                          residual},
               .openmp = {[in](In x, Out y) {
                            openmp::multiply(in->sliced_blocks, x, y);
                            return openmp::dot(x, y);
                          },
                          [d](In x, Out y) { return openmp::multiply(d->sliced, x, y), openmp::dot(x, y); },
                          residual},
               .rows = in->scene.rows,
               .b = in->scene.b,
               .matrix_bytes = bytes_of(in->sliced_blocks) + bytes_of(d->sliced),
               .matrix_flops = 2. * double(in->scene.blocks.value.size() + d->rows.value.size()),
               .best_serial = nullptr,
               .kept = in},
              in->scene.stop);
}

// Eigen's, with its own incomplete Cholesky in the order that the matrix came in. Only the solve is timed, as in the
// twins.
std::function<void(State&)> eigen_solve(const std::shared_ptr<const Inputs>& in) {
  using Matrix = Eigen::SparseMatrix<float>;
  struct Solver {
    Matrix a;
    Eigen::ConjugateGradient<Matrix, Eigen::Lower | Eigen::Upper,
                             Eigen::IncompleteCholesky<float, Eigen::Lower, Eigen::NaturalOrdering<int>>>
        solve;
  };
  const auto solver = std::make_shared<Solver>();
  return [in, solver](State& s) {
    const Rows<float>& rows = in->scene.rows;
    if (solver->a.rows() == 0) {  // the first time; symmetric, so that rows are columns
      solver->a = Eigen::Map<const Matrix>(rows.rows, rows.columns, static_cast<Eigen::Index>(rows.value.size()),
                                           rows.begin.data(), rows.column.data(), rows.value.data());
      solver->solve.setTolerance(static_cast<float>(in->scene.stop.tolerance));
      solver->solve.setMaxIterations(in->scene.stop.iterations);
      solver->solve.compute(solver->a);
    }
    Eigen::Map<Eigen::VectorXf>(s.x.data(), rows.rows) =
        solver->solve.solve(Eigen::Map<const Eigen::VectorXf>(in->scene.b.data(), rows.rows));
    s.number = {double(solver->solve.iterations()), solver->solve.error(), -1};
  };
}

System<float> by_levels(const std::shared_ptr<const Factored>& in) {
  return {[in](In x, Out y) { return openmp::multiply_and_dot(in->sliced, x, y); },
          [in](In x, Out y) { return openmp::solve(in->sliced_factor, x, y), openmp::dot(x, y); },
          [in](In b, In x) { return residual_norm(in->rows, b, x); }};
}

double bytes_of_levels(const Factored& in) {
  return bytes_of(in.sliced) + bytes_of(in.sliced_factor.lower) + bytes_of(in.sliced_factor.upper) +
         16. * in.rows.rows;  // what the solve reads and writes beyond the product
}
double flops_of_levels(const Factored& in) { return 4. * double(in.rows.value.size()) + 3. * in.rows.rows; }

Case make_incomplete_cholesky(const std::string& path) {
  const auto in = factored(path);
  const auto scene = inputs(path);
  return make({.serial = {[in](In x, Out y) { return serial::multiply_and_dot(in->rows, x, y); },
                          [in](In x, Out y) { return serial::solve(in->factor, x, y), serial::dot(x, In(y)); },
                          [in](In b, In x) { return residual_norm(in->rows, b, x); }},
               .openmp = by_levels(in),
               .rows = in->rows,
               .b = in->b,
               .matrix_bytes = bytes_of_levels(*in),
               .matrix_flops = flops_of_levels(*in),
               .best_serial = eigen_solve(scene),
               .kept = in},
              scene->scene.stop);
}

// Compares the iterations of the two orders, and asks that the order by levels converges.
Case make_incomplete_cholesky_for_natural(const std::string& path) {
  const auto in = factored(path);
  const auto scene = inputs(path);
  const Stop stop = scene->scene.stop;
  const auto factor =
      std::make_shared<const Factor<float>>(serial::incomplete_cholesky(scene->scene.rows, scene->scene.modification));
  const System<float> natural{[scene](In x, Out y) { return serial::multiply_and_dot(scene->scene.rows, x, y); },
                              [factor](In x, Out y) { return serial::solve(*factor, x, y), serial::dot(x, In(y)); },
                              [scene](In b, In x) { return residual_norm(scene->scene.rows, b, x); }};
  const System<float> levels = by_levels(in);
  const auto first = start(in->b.size());
  State solved = *first;
  const Solution solution = openmp::conjugate_gradients(levels, in->b, solved.x, stop);
  return make_case<State>({
      .start = first,
      .serial = [=](State& s) { keep(s, serial::conjugate_gradients(natural, scene->scene.b, s.x, stop)); },
      .best_serial = nullptr,
      .openmp = [=](State& s) { keep(s, openmp::conjugate_gradients(levels, in->b, s.x, stop)); },
      .compare =
          [=](const State& openmp, const State& serial) {
            Judgement judgement{.verdict = Verdict::converged,
                                .passed = true,
                                .error = openmp.number[1],
                                .bound = stop.tolerance,
                                .worst_at = ""};
            require_convergence(judgement, openmp, in->rows, in->b, stop);
            judgement.worst_at += "; natural order " + std::to_string(static_cast<int>(serial.number[0]));
            return judgement;
          },
      .work = work_of(solution, double(in->b.size()), bytes_of_levels(*in), flops_of_levels(*in)),
  });
}

bool is_solvable_in_blocks(const std::string& path) { return is_solvable(path) && has_blocks(path); }

const Register conjugate_gradients{{.name = "linear/conjugate_gradients",
                                    .place = 5,
                                    .serial_forms = {"jacobi", "block_jacobi", "incomplete_cholesky"},
                                    .forms = {
                                        {.name = "jacobi",
                                         .make = make_jacobi,
                                         .scenes = {.verify = {"poisson_32", "file_truss"},
                                                    .more = {"poisson_64"},
                                                    .bench = {"poisson_64"},
                                                    .tsan = {"poisson_32"}},
                                         .takes = is_solvable},
                                        {.name = "block_jacobi",
                                         .make = make_block_jacobi,
                                         .scenes = {.verify = {"elasticity_24"},
                                                    .more = {"elasticity_48"},
                                                    .bench = {"elasticity_24"},
                                                    .tsan = {"elasticity_24"}},
                                         .takes = is_solvable_in_blocks},
                                        {.name = "incomplete_cholesky",
                                         .make = make_incomplete_cholesky,
                                         .scenes = {.verify = {"poisson_64", "poisson_32", "file_truss"},
                                                    .more = {"poisson_128", "elasticity_24"},
                                                    .bench = {"poisson_64"},
                                                    .tsan = {"poisson_32"}},
                                         .takes = is_solvable},
                                        {.name = "incomplete_cholesky_for_natural",
                                         .make = make_incomplete_cholesky_for_natural,
                                         .scenes = {.verify = {"poisson_64", "poisson_32", "file_truss"},
                                                    .more = {"poisson_128"},
                                                    .bench = {"poisson_64"},
                                                    .tsan = {}},
                                         .covered_by = "incomplete_cholesky",
                                         .takes = is_solvable},
                                    }}};

}  // namespace
}  // namespace lockstep::verify::linear_conjugate_gradients
