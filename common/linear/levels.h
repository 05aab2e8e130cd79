// Rows of a matrix in an order in which many can be eliminated, or solved for, at once.
//
// In a triangular solve row i waits for the rows j < i in whose columns it has entries. Its level is one more than the
// greatest level of those; rows of one level do not wait for one another. On a grid of 7 points levels are the
// hyperplanes x + y + z = const.
//
// In a matrix numbered level by level, and within a level as before, a row waits for the same rows as before. So the
// factor is the same but for rounding: a sum over a row adds in another order where its columns change places. Rows of
// a level are then side by side, and so, mostly, are the columns of sixteen neighbouring rows. A solver numbers its
// unknowns so once, and keeps all its vectors in that order.
//
// Source: Saad, Iterative Methods for Sparse Linear Systems (2nd ed., 2003), 11.6: level scheduling.
#pragma once

#include <cstdint>
#include <span>

#include "common/array.h"
#include "common/linear/matrix.h"

namespace lockstep::linear {

struct Levels {
  Array<std::int32_t> order;     // [new number]: the row's old number
  Array<std::int32_t> begin{0};  // [level]: its first row, by new numbers; and the number of rows, behind the last
  int count() const { return static_cast<int>(begin.size()) - 1; }
};

// Of a square matrix whose pattern is symmetric.
template <class Real>
Levels make_levels(const Rows<Real>& a);

// Row i of the result is row order[i] of a, its columns renumbered alike.
template <class Real>
Rows<Real> reordered(const Rows<Real>& a, std::span<const std::int32_t> order);

// Element i of the result is element order[i] of x.
template <class Real>
Array<Real> reordered(std::span<const Real> x, std::span<const std::int32_t> order) {
  Array<Real> y(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) y[i] = x[order[i]];
  return y;
}

}  // namespace lockstep::linear
