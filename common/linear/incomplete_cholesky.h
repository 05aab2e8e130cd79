// Contract: the incomplete Cholesky factor of a sparse matrix, and the solve with it that preconditions conjugate
// gradients.
//
//   M = (E + L) E^-1 (E + L)^T, L strictly lower with the pattern of A, E diagonal. For j < i in the pattern of row i:
//
//     l_mi = a_mi - sum over j of l_ij l_mj / e_j          for m > i in the pattern of row i
//     e_i  = a_ii - sum over j of l_ij (l_ij + tau d_ij) / e_j
//     d_ij = sum of l_mj over m in column j, m != i, that have no entry in row i: the fill that is dropped
//     e_i  = a_ii in place of any e_i < sigma a_ii: too much was subtracted
//
//   tau = 0 is IC(0); tau = 1 keeps the sums of rows (MIC(0)). For Poisson's equation .97 to .995 is best, larger on
//   finer grids. A matrix of 7 points on a grid has l_ij = a_ij. Where no row has more than one entry behind its
//   diagonal, as in a tridiagonal matrix, nothing is dropped and M = A.
//
//   solve finds z of M z = r:
//
//     y_i = (r_i - sum over j of l_ij y_j) / e_i           rows ascending
//     z_i = y_i - (sum over m of l_mi z_m) / e_i           rows descending
//
//   Sums run over ascending j and m. 1 / e_i is rounded once; rows multiply by it.
//
// serial: rows in order. openmp: level after level, of a matrix that is numbered by its levels
// (common/linear/levels.h); the threads share a level's rows, and the solve takes sixteen of them at once. A row does
// the same operations in the same order as in serial, so the bits are the serial ones.
//
// In: A, symmetric, with a positive diagonal entry in each row. r and z do not overlap.
//
// Source: Meijerink and van der Vorst, Math. Comp. 31 (1977); Gustafsson, A class of first order factorization
//         methods, BIT 18 (1978); tau and sigma: Bridson, Fluid Simulation for Computer Graphics (2nd ed., 2015), 5.3;
//         levels: Saad, Iterative Methods for Sparse Linear Systems (2nd ed., 2003), 11.6.
#pragma once

#include <span>

#include "common/linear/levels.h"
#include "common/linear/matrix.h"
#include "common/linear/sliced.h"

namespace lockstep::linear {

struct Modification {
  double tau = .97, sigma = .25;  // both from 0 to 1
};

template <class Real>
struct Factor {
  Rows<Real> lower;     // l_ij, j < i
  Rows<Real> upper;     // the transpose: row i holds l_mi, m > i
  Array<Real> inverse;  // 1 / e_i
};

// The factor laid out for lanes. Slice s of `lower` and slice s of `upper` have the same rows; no slice crosses from
// one level to the next.
struct SlicedFactor {
  SlicedRows lower, upper;
  Array<float> inverse;
  Array<std::int32_t> first_slice;  // [level]: its first slice; and the number of slices, behind the last
};

template <class Real>
using IncompleteCholesky = Factor<Real>(const Rows<Real>& a, Modification modification);
using IncompleteCholeskyByLevels = Factor<float>(const Rows<float>& a, const Levels& levels, Modification modification);
template <class AnyFactor, class Real>
using Solve = void(const AnyFactor& factor, std::span<const Real> r, std::span<Real> z);

// Sequential; for openmp::solve.
SlicedFactor slice(const Factor<float>& factor, const Levels& levels);

namespace serial {
IncompleteCholesky<float> incomplete_cholesky;
IncompleteCholesky<double> incomplete_cholesky;
Solve<Factor<float>, float> solve;
Solve<Factor<double>, double> solve;
}  // namespace serial

namespace openmp {
IncompleteCholeskyByLevels incomplete_cholesky;
Solve<SlicedFactor, float> solve;
}  // namespace openmp

}  // namespace lockstep::linear
