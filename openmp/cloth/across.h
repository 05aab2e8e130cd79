// Chains along rows, one row a lane: sixteen rows are transposed, relaxed as if they were columns, and transposed back.
//
// No serial twin: there a chain along a row is walked particle by particle.
#pragma once

#include "common/array.h"
#include "common/simd.h"
#include "openmp/cloth/row_lanes.h"

namespace lockstep::cloth::openmp {

// Room for sixteen rows with lanes across them: element [16 c + i] is column c of row i. Missing rows are zero.
struct Across {
  Array<float> x, y, z, inverse_mass;

  explicit Across(int pitch) {
    for (Array<float>* array : {&x, &y, &z, &inverse_mass}) array->resize(lanes * pitch);
  }
  Rows columns() { return {{x.data(), y.data(), z.data()}, inverse_mass.data(), lanes}; }
};

LOCKSTEP_INLINE void transpose_in(const float* rows, int pitch, int n, float* across) {
  for (int c = 0; c < pitch; c += lanes) {
    floatv square[lanes];
    for (int i = 0; i < lanes; ++i) square[i] = i < n ? load(rows + i * pitch + c) : floatv(0.f);
    transpose(square);
    for (int i = 0; i < lanes; ++i) store(across + (c + i) * lanes, square[i]);
  }
}

LOCKSTEP_INLINE void transpose_out(const float* across, float* rows, int pitch, int n) {
  for (int c = 0; c < pitch; c += lanes) {
    floatv square[lanes];
    for (int i = 0; i < lanes; ++i) square[i] = load(across + (c + i) * lanes);
    transpose(square);
    for (int i = 0; i < n; ++i) store(rows + i * pitch + c, square[i]);
  }
}

// The passes of chains along the rows. right is 0 where a sheet has no such pass.
struct AlongRows {
  Family<float> next = {0, 0, 0}, bending = {0, 0, 0};  // tied one apart, and two apart
};

// Both passes along n <= 16 rows, from `row` on. The second pass, two apart, follows the first by two columns: that is
// all it waits for, and the two chains hide some of each other's latency.
inline void enforce_chains_along(const Rows& rows, const Sheet& sheet, int row, int n, const AlongRows& families,
                                 Across& across) {
  const int first = row * rows.pitch;
  const auto [x, y, z] = rows.position;
  transpose_in(x + first, rows.pitch, n, across.x.data());
  transpose_in(y + first, rows.pitch, n, across.y.data());
  transpose_in(z + first, rows.pitch, n, across.z.data());
  transpose_in(rows.inverse_mass + first, rows.pitch, n, across.inverse_mass.data());
  const Rows columns = across.columns();
  const auto enforce = [&](int c, int d, floatv rest_2) {
    enforce_between(columns, c * lanes, d * lanes, lanes, rest_2);
  };
  const bool bending = families.bending.right != 0;
  for (int c = 0; c + 1 < sheet.columns; ++c) {
    enforce(c, c + 1, families.next.rest_2);
    if (bending && c >= 2) enforce(c - 2, c, families.bending.rest_2);
  }
  if (bending && sheet.columns > 2) enforce(sheet.columns - 3, sheet.columns - 1, families.bending.rest_2);
  transpose_out(across.x.data(), x + first, rows.pitch, n);
  transpose_out(across.y.data(), y + first, rows.pitch, n);
  transpose_out(across.z.data(), z + first, rows.pitch, n);
}

}  // namespace lockstep::cloth::openmp
