// Sparse matrices by rows: of numbers, and of 3x3 blocks.
#pragma once

#include <cstddef>
#include <cstdint>

#include "common/array.h"
#include "common/convert.h"

namespace lockstep::linear {

// Compressed sparse rows. Row i holds value[k] at column[k] for begin[i] <= k < begin[i + 1], columns ascending and
// each at most once. Owns its arrays; begin has rows + 1 elements.
template <class Real>
struct Rows {
  int rows = 0, columns = 0;
  Array<std::int32_t> begin{0}, column;
  Array<Real> value;
};

// The same with a 3x3 block in place of a number: rows and columns count blocks, and block k is value[9 k .. 9 k + 8],
// row by row. A vector holds components 3 i, 3 i + 1 and 3 i + 2 of block row i.
template <class Real>
struct BlockRows {
  int rows = 0, columns = 0;
  Array<std::int32_t> begin{0}, column;
  Array<Real> value;
};

template <class To, class From>
Rows<To> convert(const Rows<From>& a) {
  return {a.rows, a.columns, a.begin, a.column, lockstep::convert<To>(a.value)};
}

template <class To, class From>
BlockRows<To> convert(const BlockRows<From>& a) {
  return {a.rows, a.columns, a.begin, a.column, lockstep::convert<To>(a.value)};
}

// The block rows written as rows of numbers.
template <class Real>
Rows<Real> scalar_rows(const BlockRows<Real>& a) {
  Rows<Real> rows;
  rows.rows = 3 * a.rows, rows.columns = 3 * a.columns;
  rows.begin.reserve(3 * static_cast<std::size_t>(a.rows) + 1);
  rows.column.reserve(9 * a.column.size());
  rows.value.reserve(9 * a.column.size());
  for (int i = 0; i < a.rows; ++i)
    for (int r = 0; r < 3; ++r) {
      for (int k = a.begin[i]; k < a.begin[i + 1]; ++k)
        for (int c = 0; c < 3; ++c) {
          rows.column.push_back(3 * a.column[k] + c);
          rows.value.push_back(a.value[9 * static_cast<std::size_t>(k) + 3 * r + c]);
        }
      rows.begin.push_back(static_cast<std::int32_t>(rows.column.size()));
    }
  return rows;
}

}  // namespace lockstep::linear
