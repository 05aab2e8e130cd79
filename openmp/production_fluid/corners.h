// The corners of the cells in which sixteen feet lie.
//
// Where the velocity changes little along sixteen points, all their feet are as many cells away, and their corners
// stand side by side. So the lanes whose cells are as far away as that of the first lane are served together, by loads;
// then those that are as far away as the first lane that is left, and so on. No flow needs more than sixteen rounds; a
// smooth one that moves less than a cell needs a few. With gathers, advection of velocity took 1.5 times as long on an
// EPYC.
#pragma once

#include <bit>
#include <cstdint>

#include "common/production_fluid/trace.h"
#include "common/simd.h"

namespace lockstep::production_fluid {

// Where the eight corners of a lane's cell stand in a field.
struct CornersOfLane {
  const float* corner[8];

  CornersOfLane(const float* line, std::int32_t to_line, std::int32_t to_plane)
      : corner{line,
               line + 1,
               line + to_line,
               line + to_line + 1,
               line + to_plane,
               line + to_plane + 1,
               line + to_line + to_plane,
               line + to_line + to_plane + 1} {}
};

LOCKSTEP_INLINE Corners<floatv> load_corners(const float* field, const Cell<intv>& cell) {
  alignas(64) std::int32_t to_line[lanes], to_plane[lanes], away[lanes];
  const intv cells_away = cell.first - lane_index();
  store(away, cells_away), store(to_line, cell.to_line), store(to_plane, cell.to_plane);
  // Between two lines is more padding than there are lanes, so equal distances mean the same line, and loads for the
  // lanes of other rounds stay within the array.
  const auto corners_of = [&](int lane) { return CornersOfLane(field + away[lane], to_line[lane], to_plane[lane]); };
  Corners<floatv> corners;
  const CornersOfLane of_first = corners_of(0);
  for (int k = 0; k < 8; ++k) corners.value[k] = load(of_first.corner[k]);
  for (std::uint32_t left = 0xffff & ~bits(cells_away == away[0]); left;) {
    const int lane = std::countr_zero(left);
    const maskv together = cells_away == away[lane];
    const CornersOfLane of_lane = corners_of(lane);
    for (int k = 0; k < 8; ++k) where(together, corners.value[k]) = load(of_lane.corner[k]);
    left &= ~bits(together);
  }
  return corners;
}

}  // namespace lockstep::production_fluid
