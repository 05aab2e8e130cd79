// A uniform grid that is wrapped around along each axis, so that a table of any size holds a world of any size.
//
// The hash of a cell is its coordinates modulo the table's sides, powers of two that are at least 4. Unlike a hash that
// scatters, it keeps cells that are side by side along x side by side in memory, and the 27 cells around a cell all
// have different hashes. Two cells with the same hash are at least 4 cells apart, so no box of one touches a box of the
// other: they cost candidates, and no pair is met twice.
//
// A box is in the cell of its low corner. If no side of it is longer than a cell, the low corners of two overlapping
// boxes are at most a cell apart along each axis, so they are in the same or in neighbouring cells. That holds in
// floating point, too. A coordinate, fewer than 2^15 cells, is off by two roundings, which is at most 2^-8 cells (less
// in double), and cells are 1/64 larger than need be: 64/65 + 2 * 2^-8 < 1.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "common/spatial/bounds.h"

namespace lockstep::spatial {

template <class Real>
struct WrappedGrid {
  Vector3<Real> low;  // where cell 0 0 0 begins, m
  Real scale;         // cells to the metre
  Vector3<int> bits;  // the table has 2^bits cells along an axis

  int cells() const { return 1 << (bits.x + bits.y + bits.z); }
};

template <class T>
inline T longest_side(const Box<T>& box) {
  const Vector3<T> sides = box.high - box.low;
  return max(sides.x, max(sides.y, sides.z));
}

// Cell size: exceeded by about sqrt(n) boxes. Testing those against all n costs O(n^1.5), which does not dominate.
// Estimated from an even sample of the bounded boxes.
template <class Real>
Real typical_size(const Bounds<Real>& bounds) {
  constexpr int most = 1024;
  const int step = (bounds.count + most - 1) / most;
  std::vector<Real> sizes;
  for (int i = 0; i < bounds.count; i += step)
    if (bounds.bounded(i)) sizes.push_back(longest_side(bounds.box(i)));
  if (sizes.empty()) return 0;
  const auto n = static_cast<Real>(bounds.count);
  const auto beyond = static_cast<std::size_t>(static_cast<Real>(sizes.size()) / std::sqrt(n));
  const auto place = sizes.end() - 1 - static_cast<std::ptrdiff_t>(std::min(beyond, sizes.size() - 1));
  std::nth_element(sizes.begin(), place, sizes.end());
  return *place;
}

// A grid for `n` boxes no longer than `size`, m, with low corners within `corners`. The table has 2 n cells or more,
// unless the world has fewer.
template <class Real>
WrappedGrid<Real> wrapped_grid(int n, Real size, const Box<Real>& corners) {
  WrappedGrid<Real> grid = {corners.low, 0, {2, 2, 2}};
  if (n == 0) return grid;
  const Real cell = max(max(size + size / 64, longest_side(corners) / (1 << 15)), std::numeric_limits<Real>::min());
  grid.scale = 1 / cell;
  const Vector3<Real> cells = grid.scale * (corners.high - corners.low) + Vector3<Real>{1, 1, 1};
  while (grid.cells() < 2 * n) {
    const Real x = std::ldexp(cells.x, -grid.bits.x), y = std::ldexp(cells.y, -grid.bits.y);
    const Real z = std::ldexp(cells.z, -grid.bits.z);
    if (max(x, max(y, z)) <= 1) break;
    ++(x >= y && x >= z ? grid.bits.x : y >= z ? grid.bits.y : grid.bits.z);
  }
  return grid;
}

// The coordinates of the cell that a point is in.
template <class Real, class T>
inline auto cell_at(const WrappedGrid<Real>& grid, const Vector3<T>& point) {
  const auto x = to_int((point.x - grid.low.x) * grid.scale), y = to_int((point.y - grid.low.y) * grid.scale);
  const auto z = to_int((point.z - grid.low.z) * grid.scale);
  return Vector3<std::remove_const_t<decltype(x)>>{x, y, z};
}

// Where in the table a cell is. T is int or intv.
template <class Real, class T>
inline T hash(const WrappedGrid<Real>& grid, const Vector3<T>& cell) {
  const T x = cell.x & T((1 << grid.bits.x) - 1), y = cell.y & T((1 << grid.bits.y) - 1);
  const T z = cell.z & T((1 << grid.bits.z) - 1);
  return (z << T(grid.bits.y) | y) << T(grid.bits.x) | x;
}

// Calls meet(begin, end) for runs of boxes in the order of the table: the boxes after box k in its own cell, and those
// of half of the cells around it, so that of two neighbouring cells one meets the other. begin[h] is where the boxes of
// hash h begin.
template <class Real, class Meet>
inline void for_each_forward_run(const WrappedGrid<Real>& grid, const std::int32_t* begin,
                                 const Vector3<int>& cell_of_box, int k, const Meet& meet) {
  // Within the table first: a box that is not finite is in the cell INT32_MIN, which has none before it.
  const auto within = [](int x, int bits) { return x & ((1 << bits) - 1); };
  const Vector3<int> cell = {within(cell_of_box.x, grid.bits.x), within(cell_of_box.y, grid.bits.y),
                             within(cell_of_box.z, grid.bits.z)};
  const int own = hash(grid, cell), next = hash<Real, int>(grid, {cell.x + 1, cell.y, cell.z});
  if (next == own + 1) {
    meet(k + 1, begin[next + 1]);
  } else {
    meet(k + 1, begin[own + 1]);
    meet(begin[next], begin[next + 1]);
  }
  for (const auto& [dy, dz] : {std::pair{1, 0}, {-1, 1}, {0, 1}, {1, 1}}) {
    const int first = hash<Real, int>(grid, {cell.x - 1, cell.y + dy, cell.z + dz});
    const int last = hash<Real, int>(grid, {cell.x + 1, cell.y + dy, cell.z + dz});
    if (first < last) {
      meet(begin[first], begin[last + 1]);
    } else {
      const int in_row = (1 << grid.bits.x) - 1;
      meet(begin[first], begin[(first | in_row) + 1]);
      meet(begin[last & ~in_row], begin[last + 1]);
    }
  }
}

}  // namespace lockstep::spatial
