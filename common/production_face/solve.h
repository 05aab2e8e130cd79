// Contract: K x = b, the linear system of a step of Newton's method, by conjugate gradients.
//
//   plain          M = 1
//   block_jacobi   M^-1 is the inverse of each 3x3 block on the diagonal of K
//   multigrid      M^-1 is a cycle of multigrid, of the same blocks and rigid motions of aggregates (multigrid.h)
//
// The loop is linear/'s (common/linear/conjugate_gradients.h). It works in Real; x is a sum in double, from which the
// loop refreshes its residual. Dot products are summed as common/linear/dot.h says, so a solve has the same bits at
// every number of threads.
//
// In:      k, as assemble makes it: symmetric, rows of held nodes empty, so that x stays 0 there and their columns do
//          not matter; b, 0 at held nodes; when to stop.
// Out:     x, the sum rounded to Real; it does not overlap b.
// Returns: the iterations; the residual of the sum, by which the loop stops; and the true one of x, whose rounding
//          leaves up to u |K| |x| besides. Both are computed in double. Where K is found not to be definite, a solve
//          ends before it reaches the tolerance. That is not an error: exact derivatives may make K so.
// Scratch: memory of multigrid, made for the coarsening of k's body and for k (make_multigrid).
// Source: [ITJ07] "Production Face"; Saad, Iterative Methods for Sparse Linear Systems (2nd ed., 2003), 9.2 and 10.2.
#pragma once

#include <span>

#include "common/linear/conjugate_gradients.h"
#include "common/linear/matrix.h"
#include "common/linear/sliced.h"
#include "common/math.h"
#include "common/production_face/multigrid.h"

namespace lockstep::production_face {

template <class Matrix, class Real>
using Solve = linear::Solution(const Matrix& k, std::span<const Real> b, const linear::Stop& stop, std::span<Real> x);

template <class Matrix, class Real>
using SolveWithLevels = linear::Solution(const Coarsening<Real>& coarsening, const Matrix& k, std::span<const Real> b,
                                         const linear::Stop& stop, std::span<Real> x, Multigrid<Real, Matrix>& memory);

namespace serial {
Solve<linear::BlockRows<float>, float> solve_plain, solve_block_jacobi;
SolveWithLevels<linear::BlockRows<float>, float> solve_multigrid;
Solve<linear::BlockRows<double>, double> solve_plain, solve_block_jacobi;
SolveWithLevels<linear::BlockRows<double>, double> solve_multigrid;
}  // namespace serial

namespace openmp {
Solve<linear::SlicedBlockRows, float> solve_plain, solve_block_jacobi;
SolveWithLevels<linear::SlicedBlockRows, float> solve_multigrid;
}  // namespace openmp

// --- Formulas; of numbers or of lanes

// A symmetric 3x3 block: its diagonal, and the elements (c, c + 1) beside it, c + 1 being 0 after 2.
template <class Number>
struct SymmetricBlock {
  Number diagonal[3], next[3];
};

// The inverse of a block on K's diagonal. A block whose minors do not show beyond rounding that it is definite gives
// 1 / (|xx| + |yy| + |zz|) on the diagonal, and a block of 0 gives 0: M must be definite even where K is not.
template <class Number>
inline SymmetricBlock<Number> inverse(const SymmetricBlock<Number>& block) {
  const auto next = [](int c) { return (c + 1) % 3; };
  // Divided by its size, as products of three of its elements may overflow.
  const Number size = abs(block.diagonal[0]) + abs(block.diagonal[1]) + abs(block.diagonal[2]);
  const auto is_there = size > Number(0);
  const Number unit = select(is_there, Number(1) / select(is_there, size, Number(1)), Number(0));
  SymmetricBlock<Number> a, cofactor;
  for (int c = 0; c < 3; ++c) a.diagonal[c] = block.diagonal[c] * unit, a.next[c] = block.next[c] * unit;
  for (int c = 0; c < 3; ++c) {
    const int i = next(c), j = next(i);
    cofactor.diagonal[c] = a.diagonal[i] * a.diagonal[j] - a.next[i] * a.next[i];
    cofactor.next[c] = a.next[i] * a.next[j] - a.next[c] * a.diagonal[j];
  }
  const Number determinant =
      (a.diagonal[0] * cofactor.diagonal[0] + a.next[0] * cofactor.next[0]) + a.next[2] * cofactor.next[2];
  // The least minors of a unit block that rounding cannot have made, with room to spare.
  const Number margin(1e-5f);
  const Number product = a.diagonal[0] * a.diagonal[1];
  const auto is_definite = (a.diagonal[0] > Number(0)) & (cofactor.diagonal[2] > margin * product) &
                           (determinant > margin * (product * a.diagonal[2]));
  const Number by_determinant = unit / select(is_definite, determinant, Number(1));
  SymmetricBlock<Number> result;
  for (int c = 0; c < 3; ++c) {
    result.diagonal[c] = select(is_definite, cofactor.diagonal[c] * by_determinant, unit);
    result.next[c] = select(is_definite, cofactor.next[c] * by_determinant, Number(0));
  }
  return result;
}

// Element c of a symmetric block's product: `diagonal` and `next` are the block's at c, `before` its `next` at c - 1; r
// likewise.
template <class Number>
inline Number row_times(const Number& diagonal, const Number& next, const Number& before, const Number& r,
                        const Number& r_next, const Number& r_before) {
  return diagonal * r + (next * r_next + before * r_before);
}

}  // namespace lockstep::production_face
