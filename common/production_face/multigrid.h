// Multigrid for K of a face. One cycle, z of r, is the preconditioner of the form `multigrid` (solve.h):
//
//   z = S r,   S = w times the inverse of the blocks on the diagonal: 3x3 of K, 6x6 of a coarse matrix A = P^T K P
//   z += P C P^T (r - A z),   C r the z of the next level (coarsening.h)
//   z += S (r - A z)
//
// on coarse levels all of this twice, going on from z; on the last level A^-1 r, by a factor of A in double.
//
// A tetrahedron couples four nodes, and so at most four aggregates. So the eigenvalues of the diagonal's inverse times
// A are at most 4 where K is semi-definite, and with w = 1/2 smoothing enlarges no error: the cycle is symmetric, and
// definite.
//
// Of a 6x6 block that is not definite beyond rounding, S leaves out the rows whose pivots show it, and smoothing leaves
// them as they are; likewise rows of rotations that are 0 (coarsening.h). 3x3 blocks of K are inverted as solve.h says.
// Where the last matrix is not definite, it has no factor, and S takes its place. Where K is not definite, the cycle
// may not be either. Conjugate gradients then stop.
//
// Source: Saad, Iterative Methods for Sparse Linear Systems (2nd ed., 2003), 13.4; Vanek, Mandel and Brezina (1996).
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "common/linear/sliced.h"
#include "common/math.h"
#include "common/production_face/coarsening.h"

namespace lockstep::production_face {

// A factor of a symmetric, definite matrix in double.
class CoarseFactor;

// A factor of A; rows that are 0 get a 1 on the diagonal. Null where A is not definite beyond the rounding of K.
template <class Real>
std::shared_ptr<const CoarseFactor> factor(const linear::BlockRows<Real>& a);
// z = A^-1 r.
template <class Real>
void solve(const CoarseFactor& factor, std::span<const Real> r, std::span<Real> z);

// The values of a level, and scratch.
template <class Real, class Matrix>
struct MultigridLevel {
  Matrix a, smoother;                   // S: the blocks on A's diagonal, inverted
  Array<std::int32_t> at, at_smoother;  // openmp: where element 0 of a block of A, and of S, is in its values
  Array<Real> r, z, rest, product;      // [6 aggregate + c]
};

template <class Real, class Matrix>
struct Multigrid {
  std::vector<MultigridLevel<Real, Matrix>> level;
  Array<std::int32_t> at;                    // openmp: the same of K
  std::shared_ptr<const CoarseFactor> last;  // null if the last level's matrix is not definite
};

// Room for the levels of a face, whose matrix has the blocks of k.
template <class Real, class Matrix>
using MakeMultigrid = Multigrid<Real, Matrix>(const Coarsening<Real>& coarsening, const Matrix& k);

// The coarse matrices of K, their smoothers, and the factor of the last.
template <class Real, class Matrix>
using SetCoarse = void(const Coarsening<Real>& coarsening, const Matrix& k, Multigrid<Real, Matrix>& m);

// z += P C P^T r, from the nodes to the first level and back.
template <class Real, class Matrix>
using Correct = void(const Coarsening<Real>& coarsening, std::span<const Real> r, std::span<Real> z,
                     Multigrid<Real, Matrix>& m);

namespace serial {
MakeMultigrid<float, linear::BlockRows<float>> make_multigrid;
MakeMultigrid<double, linear::BlockRows<double>> make_multigrid;
SetCoarse<float, linear::BlockRows<float>> set_coarse;
SetCoarse<double, linear::BlockRows<double>> set_coarse;
Correct<float, linear::BlockRows<float>> correct;
Correct<double, linear::BlockRows<double>> correct;
}  // namespace serial

namespace openmp {
MakeMultigrid<float, linear::SlicedBlockRows> make_multigrid;
SetCoarse<float, linear::SlicedBlockRows> set_coarse;
Correct<float, linear::SlicedBlockRows> correct;
}  // namespace openmp

inline constexpr int visits = 2;  // of a coarse level, at a time

inline constexpr float damping = .5f;  // w

// --- Formulas; of numbers or of lanes

template <class Number>
struct Triple {
  Number c[3];
};

// a x b
template <class Number>
LOCKSTEP_INLINE Triple<Number> crossed(const Triple<Number>& a, const Triple<Number>& b) {
  return {{a.c[1] * b.c[2] - a.c[2] * b.c[1], a.c[2] * b.c[0] - a.c[0] * b.c[2], a.c[0] * b.c[1] - a.c[1] * b.c[0]}};
}

template <class Number>
struct Block3 {
  Number e[3][3];
};

// K_ij of two members, parts x parts blocks.
template <class Number, int parts>
struct MemberBlocks {
  Block3<Number> part[parts][parts];
};

// P_i^T K_ij P_j, with the arms of i and j. R v = v x d and R^T v = d x v, so that a row of K R is d_j x the row of K,
// and a column of R^T K is d_i x the column of K.
template <class Number, int parts>
LOCKSTEP_INLINE MemberBlocks<Number, 2> coupled(const MemberBlocks<Number, parts>& k, const Triple<Number>& arm_i,
                                                const Triple<Number>& arm_j) {
  MemberBlocks<Number, 2> right, result;  // K P_j; of nodes its second row is not there
  for (int p = 0; p < parts; ++p) {
    right.part[p][0] = k.part[p][0];
    for (int r = 0; r < 3; ++r) {
      const auto& row = k.part[p][0].e[r];
      const Triple<Number> turned = crossed(arm_j, {{row[0], row[1], row[2]}});
      for (int c = 0; c < 3; ++c) {
        right.part[p][1].e[r][c] = turned.c[c];
        if constexpr (parts == 2) right.part[p][1].e[r][c] = turned.c[c] + k.part[p][1].e[r][c];
      }
    }
  }
  for (int q = 0; q < 2; ++q) {
    result.part[0][q] = right.part[0][q];
    for (int c = 0; c < 3; ++c) {
      const auto& top = right.part[0][q].e;
      const Triple<Number> turned = crossed(arm_i, {{top[0][c], top[1][c], top[2][c]}});
      for (int r = 0; r < 3; ++r) {
        result.part[1][q].e[r][c] = turned.c[r];
        if constexpr (parts == 2) result.part[1][q].e[r][c] = turned.c[r] + right.part[1][q].e[r][c];
      }
    }
  }
  return result;
}

// A symmetric 6x6 block.
template <class Number>
struct Block6 {
  Number e[6][6];
};

// w times the inverse of a block, by L D L^T. A pivot that is not positive beyond the rounding of its row leaves the
// row out: 0 in the inverse.
template <class Number>
LOCKSTEP_INLINE Block6<Number> smoother_of(const Block6<Number>& a) {
  const Number margin(1e-5f);
  Number lower[6][6], pivot[6], reciprocal[6];
  for (int j = 0; j < 6; ++j) {
    pivot[j] = a.e[j][j];
    for (int k = 0; k < j; ++k) pivot[j] = pivot[j] - lower[j][k] * lower[j][k] * pivot[k];
    const auto is_there = pivot[j] > margin * abs(a.e[j][j]);
    reciprocal[j] = select(is_there, Number(1) / select(is_there, pivot[j], Number(1)), Number(0));
    for (int i = j + 1; i < 6; ++i) {
      Number sum = a.e[i][j];
      for (int k = 0; k < j; ++k) sum = sum - lower[i][k] * lower[j][k] * pivot[k];
      lower[i][j] = sum * reciprocal[j];
    }
  }
  // L^-1, in place; its diagonal is 1.
  for (int j = 0; j < 6; ++j)
    for (int i = j + 1; i < 6; ++i) {
      Number sum = lower[i][j];
      for (int k = j + 1; k < i; ++k) sum = sum + lower[i][k] * lower[k][j];
      lower[i][j] = -sum;
    }
  const auto inverse_lower = [&](int i, int j) { return i == j ? Number(1) : lower[i][j]; };
  Block6<Number> result;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j <= i; ++j) {
      Number sum(0);
      for (int k = i; k < 6; ++k) sum = sum + inverse_lower(k, i) * inverse_lower(k, j) * reciprocal[k];
      result.e[i][j] = result.e[j][i] = Number(damping) * sum;
    }
  return result;
}

}  // namespace lockstep::production_face
