// Sparse matrices laid out for lanes: sixteen rows are a slice, and each lane of a vector works on one of them.
//
// A row's entries keep their order, so that a lane adds what a scalar loop over the row adds, in the same order. Made
// once, by sequential code, from the plain rows of common/linear/matrix.h; values are copied.
//
// Source: sliced ELLPACK: Monakov, Lokhmotov and Avetisyan, Automatically tuning sparse matrix-vector
//         multiplication for GPU architectures (HiPEAC 2010); sorting by length in windows: Kreutzer et al., A unified
//         sparse matrix data format for efficient general sparse matrix-vector multiplication on modern processors
//         with wide SIMD units (SIAM J. Sci. Comput. 36, 2014).
#pragma once

#include <cstdint>
#include <span>

#include "common/array.h"
#include "common/linear/matrix.h"
#include "common/simd.h"

namespace lockstep::linear {

// Rows of numbers. A slice is up to sixteen rows that stand one after another; it holds slots, one entry of each active
// lane.
//
// Where rows are numbered along a grid, lane l's column is the first lane's plus l: such a slot stores one column for
// all lanes, and its entries of x are one load. Where all values of a slot are equal, it stores one value. Both are
// found out from the matrix, slice by slice; a slice whose columns make no such runs gathers. A Poisson matrix of 7
// points takes 8 bytes a row in place of 56.
struct SlicedRows {
  struct Slot {
    std::int32_t place;   // column - lane, which may be negative; of a slot that gathers: where in `column` it begins
    std::int32_t values;  // where in `value` it begins: one value, or sixteen
    std::uint16_t mask;   // active lanes
    bool gathers : 1, uniform : 1;
    bool inside : 1;  // all of place .. place + 15 are columns; false of a slot that gathers
  };
  int rows = 0, columns = 0;
  Array<std::int32_t> first_row{0};   // [slice]: its first row; and the number of rows, behind the last
  Array<std::int32_t> first_slot{0};  // [slice]: its first slot; and the number of slots, behind the last
  Array<Slot> slots;
  Array<std::int32_t> column;
  Array<float> value;

  int slices() const { return static_cast<int>(first_row.size()) - 1; }
};

// Slices do not cross from one group of rows to the next: group g is the rows groups[g] .. groups[g + 1] - 1, and
// groups run from 0 to a.rows. Throws std::length_error where `value` or `column` would exceed 2^31 - 17 elements.
SlicedRows slice(const Rows<float>& a, std::span<const std::int32_t> groups);
SlicedRows slice(const Rows<float>& a);  // all rows are one group

// Block rows. Lanes of a slice take rows of like length: the rows of a window of 256 are sorted by length, long rows
// first, before they are cut into slices. Entry e = 3 r + c of the block in lane l of slot k is
// value[16 (9 k + e) + l].
struct SlicedBlockRows {
  int rows = 0, columns = 0;          // in blocks
  Array<std::int32_t> row;            // [16 slice + lane]: the row of the lane; -1 of lanes beyond the last row
  Array<std::int32_t> length;         // [16 slice + lane]: blocks of the row; the lane is active in as many slots
  Array<std::int32_t> first_slot{0};  // [slice]: as in SlicedRows
  Array<std::int32_t> column;         // [16 slot + lane]; 0 where the lane is inactive
  Array<float> value;

  int slices() const { return static_cast<int>(first_slot.size()) - 1; }
};

// Throws std::length_error where `column` would exceed 2^31 - 17 elements.
SlicedBlockRows slice(const BlockRows<float>& a);

// Bytes that a product reads of the matrix.
double bytes_of(const SlicedRows& a);
double bytes_of(const SlicedBlockRows& a);

}  // namespace lockstep::linear
