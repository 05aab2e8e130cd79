// The corners of the cells in which sixteen particles lie, for particles of which many share a cell.
//
// Particles are sorted by block, sixteen a block or so, and the block is a cell of the fields at centres. So the lanes
// that are in the cell of the first lane are served together: each corner is loaded once, for all of them. Then those
// in the cell of the first lane that is left, and so on. (corners.h serves lanes whose cells follow one another.)
#pragma once

#include <bit>
#include <cstdint>

#include "common/production_fluid/trace.h"
#include "common/simd.h"

namespace lockstep::production_fluid {

// Of several fields of one shape.
template <int count>
LOCKSTEP_INLINE void load_shared_corners(const Field<float>* const (&fields)[count], const Cell<intv>& cell,
                                         Corners<floatv> (&corners)[count]) {
  alignas(64) std::int32_t to_line[lanes], to_plane[lanes], first[lanes];
  store(first, cell.first), store(to_line, cell.to_line), store(to_plane, cell.to_plane);
  std::uint32_t left = 0xffff;
  do {
    const int lane = std::countr_zero(left);
    const maskv together = cell.first == first[lane];
    for (int f = 0; f < count; ++f) {
      const float* const origin = &fields[f]->value[fields[f]->index(0, 0, 0)];
      const Corners<float> shared =
          load_corners(origin, Cell<std::int32_t>{first[lane], to_line[lane], to_plane[lane]});
      for (int k = 0; k < 8; ++k) where(together, corners[f].value[k]) = shared.value[k];
    }
    left &= ~bits(together);
  } while (left);
}

}  // namespace lockstep::production_fluid
