// CHOLMOD (SuiteSparse): a Cholesky factor in the order that it finds best, and a solve with it.
#include <suitesparse/cholmod.h>

#include <memory>
#include <stdexcept>

#include "notes/peers/pressure.h"
#include "verify/program.h"

namespace lockstep::peers {
namespace {

class Cholmod {
 public:
  explicit Cholmod(const Problem& problem) {
    cholmod_start(&common_);
    const linear::Rows<double>& a = problem.matrix;
    cholmod_triplet* const entries =
        cholmod_allocate_triplet(a.rows, a.rows, a.value.size(), 1, CHOLMOD_REAL, &common_);
    for (int i = 0; i < a.rows; ++i)
      for (int k = a.begin[i]; k < a.begin[i + 1]; ++k)
        if (a.column[k] >= i) {
          static_cast<int*>(entries->i)[entries->nnz] = i;
          static_cast<int*>(entries->j)[entries->nnz] = a.column[k];
          static_cast<double*>(entries->x)[entries->nnz++] = a.value[k];
        }
    matrix_ = cholmod_triplet_to_sparse(entries, 0, &common_);
    right_ = cholmod_allocate_dense(a.rows, 1, a.rows, CHOLMOD_REAL, &common_);
    std::copy(problem.right.begin(), problem.right.end(), static_cast<double*>(right_->x));
  }

  Answer solve() {
    const double start = verify::now();
    cholmod_factor* factor = cholmod_analyze(matrix_, &common_);
    cholmod_factorize(matrix_, factor, &common_);
    if (common_.status != CHOLMOD_OK) throw std::runtime_error("CHOLMOD: status " + std::to_string(common_.status));
    Answer answer;
    answer.setup_s = verify::now() - start;
    cholmod_dense* solution = cholmod_solve(CHOLMOD_A, factor, right_, &common_);
    const double* const x = static_cast<const double*>(solution->x);
    answer.x.assign(x, x + right_->nrow);
    cholmod_free_dense(&solution, &common_);
    cholmod_free_factor(&factor, &common_);
    return answer;
  }

 private:
  cholmod_common common_;
  cholmod_sparse* matrix_;
  cholmod_dense* right_;
};

}  // namespace
}  // namespace lockstep::peers

int main(int count, char** words) {
  using namespace lockstep;
  using namespace lockstep::peers;
  return report([&](Json& rows) {
    compare_solvers(
        rows, asked(count, words), "multigrid", production_fluid::openmp::pressure_solve_multigrid,
        [](const Problem& problem, int) {
          const auto cholmod = std::make_shared<Cholmod>(problem);
          return [cholmod] { return cholmod->solve(); };
        },
        "CHOLMOD solves to rounding, in double, and could keep its analysis and its factor for other right sides; ours"
        " to the tolerance. With the system's BLAS, on one thread.");
  });
}
