// Morton codes: the bits of three coordinates in turn, so that points whose codes are near are mostly near each other. For T an int32 or
// intv.
#pragma once

#include "common/math.h"
#include "common/spatial/bounds.h"

namespace lockstep::spatial {

inline constexpr int morton_bits = 30;
inline constexpr int morton_cells = 1 << morton_bits / 3;  // along an axis

// Two zeros between every two bits of x, 0 <= x < 1024.
template <class T>
inline T spread_bits(T x) {
  x = (x | x << 16) & 0x030000ff;
  x = (x | x << 8) & 0x0300f00f;
  x = (x | x << 4) & 0x030c30c3;
  return (x | x << 2) & 0x09249249;
}

template <class T>
inline T morton_code(T x, T y, T z) {
  return spread_bits(x) << 2 | spread_bits(y) << 1 | spread_bits(z);
}

// Cells to the metre of a box around all points: of its longest side.
template <class Real>
inline Real morton_scale(const Box<Real>& extent) {
  const Vector3<Real> sides = extent.high - extent.low;
  const Real longest = max(sides.x, max(sides.y, sides.z));
  return longest > 0 ? (morton_cells - 1) / longest : 0;
}

// Of a point in a cube that begins at `low`, cut into morton_cells along each side; `scale` is of them to the metre.
template <class T>
inline auto morton_code(const Vector3<T>& point, const Vector3<T>& low, T scale) {
  const Vector3<T> cell = scale * (point - low);
  return morton_code(to_int(cell.x), to_int(cell.y), to_int(cell.z));
}

}  // namespace lockstep::spatial
