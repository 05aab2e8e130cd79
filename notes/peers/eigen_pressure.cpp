// Eigen: conjugate gradients preconditioned by its incomplete Cholesky factor.
#include <eigen3/Eigen/Sparse>

#include <memory>

#include "notes/peers/pressure.h"
#include "verify/program.h"

int main(int count, char** words) {
  using namespace lockstep;
  using namespace lockstep::peers;
  using Matrix = Eigen::SparseMatrix<double, Eigen::RowMajor>;  // Eigen's products of this form use threads
  using Factor = Eigen::IncompleteCholesky<double, Eigen::Lower, Eigen::NaturalOrdering<int>>;
  return report([&](Json& rows) {
    compare_solvers(
        rows, asked(count, words), "mic", production_fluid::openmp::pressure_solve_mic,
        [](const Problem& problem, int threads) {
          Eigen::setNbThreads(threads);
          const linear::Rows<double>& a = problem.matrix;
          const auto matrix = std::make_shared<const Matrix>(Eigen::Map<const Matrix>(
              a.rows, a.columns, Eigen::Index(a.value.size()), a.begin.data(), a.column.data(), a.value.data()));
          return [matrix, &problem] {
            const double start = verify::now();
            Eigen::ConjugateGradient<Matrix, Eigen::Lower | Eigen::Upper, Factor> solver;
            solver.setTolerance(problem.tolerance);
            solver.setMaxIterations(1000);
            solver.compute(*matrix);
            Answer answer;
            answer.setup_s = verify::now() - start;
            const Eigen::Map<const Eigen::VectorXd> right(problem.right.data(), Eigen::Index(problem.right.size()));
            const Eigen::VectorXd x = solver.solve(right);
            answer.iterations = int(solver.iterations());
            answer.x.assign(x.data(), x.data() + x.size());
            return answer;
          };
        },
        "Eigen in double, ours in float with a sum and residuals in double. Eigen's factor is IC(0), in the order of"
        " cells, ours is modified (MIC(0), tau .97). Eigen's product uses the threads, its factor one.",
        true);
  });
}
