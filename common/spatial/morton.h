// Morton codes: the bits of three coordinates in turn, so that points whose codes are near are mostly near each other.
// T is int32 or intv.
#pragma once

#include "common/math.h"
#include "common/spatial/bounds.h"

namespace lockstep::spatial {

inline constexpr int morton_bits = 30;
inline constexpr int morton_cells = 1 << morton_bits / 3;  // along an axis

// Puts two zeros between every two bits of x, 0 <= x < 1024.
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

// Cells to the metre for points in a box: its longest side has them all.
template <class Real>
inline Real morton_scale(const Box<Real>& extent) {
  const Vector3<Real> sides = extent.high - extent.low;
  const Real longest = max(sides.x, max(sides.y, sides.z));
  return longest > 0 ? (morton_cells - 1) / longest : 0;
}

// The code of a point in a cube that begins at `low` and is cut into morton_cells along each side; `scale` is cells to
// the metre. A point at infinity, where scale is 0 and the product NaN, gets the last cell. T is Real or floatv.
template <class T, class Real>
inline auto morton_code(const Vector3<T>& point, const Vector3<Real>& low, Real scale) {
  const Vector3<T> cell = T(scale) * (point - Vector3<T>{low.x, low.y, low.z});
  const T last = T(morton_cells - 1);
  return morton_code(to_int(min(cell.x, last)), to_int(min(cell.y, last)), to_int(min(cell.z, last)));
}

}  // namespace lockstep::spatial
