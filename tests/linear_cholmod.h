// Direct solutions by CHOLMOD: an oracle.
#pragma once

#include <suitesparse/cholmod.h>

#include <algorithm>

#include "common/linear/matrix.h"

namespace lockstep::linear {

// A factor of a symmetric, definite matrix in double, and solves with it. Simplicial: of one thread, and without BLAS.
class DirectSolver {
 public:
  template <class Real>
  explicit DirectSolver(const Rows<Real>& a) : rows_(a.rows) {
    cholmod_start(&common_);
    common_.supernodal = CHOLMOD_SIMPLICIAL;
    cholmod_triplet* entries = cholmod_allocate_triplet(a.rows, a.rows, a.value.size(), 1, CHOLMOD_REAL, &common_);
    for (int i = 0; i < a.rows; ++i)
      for (int k = a.begin[i]; k < a.begin[i + 1]; ++k)
        if (a.column[k] >= i) {
          static_cast<int*>(entries->i)[entries->nnz] = i;
          static_cast<int*>(entries->j)[entries->nnz] = a.column[k];
          static_cast<double*>(entries->x)[entries->nnz++] = a.value[k];
        }
    cholmod_sparse* matrix = cholmod_triplet_to_sparse(entries, 0, &common_);
    factor_ = cholmod_analyze(matrix, &common_);
    cholmod_factorize(matrix, factor_, &common_);
    cholmod_free_sparse(&matrix, &common_), cholmod_free_triplet(&entries, &common_);
  }
  ~DirectSolver() {
    cholmod_free_factor(&factor_, &common_);
    cholmod_finish(&common_);
  }
  DirectSolver(const DirectSolver&) = delete;
  DirectSolver& operator=(const DirectSolver&) = delete;

  // x of A x = b.
  template <class Real>
  Array<double> operator()(const Array<Real>& b) {
    cholmod_dense* right = cholmod_allocate_dense(rows_, 1, rows_, CHOLMOD_REAL, &common_);
    std::copy(b.begin(), b.end(), static_cast<double*>(right->x));
    cholmod_dense* solution = cholmod_solve(CHOLMOD_A, factor_, right, &common_);
    const double* const x = static_cast<const double*>(solution->x);
    Array<double> result(x, x + rows_);
    cholmod_free_dense(&solution, &common_), cholmod_free_dense(&right, &common_);
    return result;
  }

 private:
  int rows_;
  cholmod_common common_;
  cholmod_factor* factor_;
};

}  // namespace lockstep::linear
