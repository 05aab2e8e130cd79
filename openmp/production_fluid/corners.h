// The corners of the cells in which sixteen feet lie.
//
// Where the velocity changes little along sixteen points, all their feet are as many cells away, and what they need
// stands side by side. So the lanes whose cells are as far away as that of the first lane are served together, by
// loads; then those that are as far away as the first lane that is left, and so on. No flow needs more than sixteen
// rounds; a smooth one that moves less than a cell needs a few. With gathers, advection of velocity took 1.5 times as
// long on an EPYC.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

#include "common/production_fluid/trace.h"
#include "common/simd.h"

namespace lockstep::production_fluid {

// The first of the sixteen of n elements that are computed at once for `begin`. At the end of a line it lies before
// `begin`: a lane beyond the end would cost a round for itself, while an element may be computed twice.
inline int first_of_full(int begin, int n) { return std::max(0, std::min(begin, n - lanes)); }

LOCKSTEP_INLINE Corners<floatv> load_corners(const float* field, const Cell<intv>& cell) {
  alignas(64) std::int32_t to_line[lanes], to_plane[lanes], away[lanes];
  const intv cells_away = cell.first - lane_index();
  store(away, cells_away), store(to_line, cell.to_line), store(to_plane, cell.to_plane);
  Corners<floatv> corners;
  std::uint32_t left = 0xffff;
  do {
    const int lane = std::countr_zero(left);
    // Between two lines is more padding than there are lanes, so equal distances mean the same line.
    const maskv together = cells_away == away[lane];
    const float* const line = field + away[lane];
    const float* const next = line + to_line[lane];
    const std::int32_t plane = to_plane[lane];
    const float* const corner[8] = {line,         line + 1,         next,         next + 1,
                                    line + plane, line + plane + 1, next + plane, next + plane + 1};
    for (int k = 0; k < 8; ++k) where(together, corners.value[k]) = load(corner[k], together);
    left &= ~bits(together);
  } while (left);
  return corners;
}

}  // namespace lockstep::production_fluid
