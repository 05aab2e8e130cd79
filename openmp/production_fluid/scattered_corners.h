// The corners of the cells in which sixteen positions lie, wherever these are: two neighbours along x by one access of
// eight bytes a lane. For drops of spray, which lie anywhere, and for the few particles near obstacles; line_corners.h
// is for particles of which many are near one another.
#pragma once

#include "common/production_fluid/trace.h"
#include "common/simd.h"

namespace lockstep::production_fluid {

struct ScatteredCorners {
  LOCKSTEP_INLINE Corners<floatv> operator()(const float* field, const Cell<intv>& cell) const {
    Corners<floatv> corners;
    const auto pair = [&](int k, const intv& first) {
      const Halves both = gather_pairs(field, first);
      corners.value[k] = both.first, corners.value[k + 1] = both.second;
    };
    pair(0, cell.first), pair(2, cell.first + cell.to_line);
    pair(4, cell.first + cell.to_plane), pair(6, cell.first + cell.to_plane + cell.to_line);
    return corners;
  }
};

}  // namespace lockstep::production_fluid
