// Contract: the product of a sparse matrix and a vector, y = A x.
//
// y_i = sum over the entries of row i, in their order, of a_ij x_j, beginning at 0. Of a block row, component r adds
// (a_r0 x_0 + a_r1 x_1) + a_r2 x_2 of each block in order. Products and sums round once each; an empty row gives 0.
//
//   rows         serial: compressed rows. openmp: sixteen rows a slice (SlicedRows).
//   block_rows   serial: compressed rows of 3x3 blocks. openmp: sixteen block rows a slice (SlicedBlockRows).
//   rows_and_dot rows of a square matrix, and x . y, summed as dot does (common/linear/dot.h). openmp: in one pass; the
//                slices are of one group, so that slice s begins at row 16 s.
//   residual     block rows, r = b - A x in double, of an x in double: each product a_rc x_c is subtracted from b_r, in
//                the order of the row; what is left is rounded to Real.
//
// In: A; x, an element a column of A (three a block). Out: y or r, an element a row of A (three a block). Vectors do
// not overlap and need no alignment; nothing beyond their ends is touched, and x_j is read only if column j has an
// entry.
//
// Source: Saad, Iterative Methods for Sparse Linear Systems (2nd ed., 2003), 3.4 and 11.5.
#pragma once

#include <span>

#include "common/linear/matrix.h"
#include "common/linear/sliced.h"

namespace lockstep::linear {

template <class Matrix, class Real>
using Multiply = void(const Matrix& a, std::span<const Real> x, std::span<Real> y);
template <class Matrix, class Real>
using MultiplyAndDot = double(const Matrix& a, std::span<const Real> x, std::span<Real> y);
template <class Matrix, class Real>
using Residual = void(const Matrix& a, std::span<const Real> b, std::span<const double> x, std::span<Real> r);

namespace serial {
Multiply<Rows<float>, float> multiply;
Multiply<Rows<double>, double> multiply;
Multiply<BlockRows<float>, float> multiply;
Multiply<BlockRows<double>, double> multiply;
MultiplyAndDot<Rows<float>, float> multiply_and_dot;
MultiplyAndDot<Rows<double>, double> multiply_and_dot;
Residual<BlockRows<float>, float> residual;
Residual<BlockRows<double>, double> residual;
}  // namespace serial

namespace openmp {
Multiply<SlicedRows, float> multiply;
Multiply<SlicedBlockRows, float> multiply;
MultiplyAndDot<SlicedRows, float> multiply_and_dot;
Residual<SlicedBlockRows, float> residual;
}  // namespace openmp

}  // namespace lockstep::linear
