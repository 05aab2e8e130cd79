// The corners of the cells in which sixteen particles lie, for particles of which many are near one another.
//
// Particles are sorted by block, along x first, and move by less than a cell until they are sorted again. So the cells
// of sixteen begin on one to four lines of a field, within sixteen values of each other. Lanes of one line are served
// together: each of the four lines around their cells is loaded once, and each lane takes its two values out of the
// register. Wherever particles are, the corners are right; if they are far apart, scattered_corners.h is faster. Lanes
// that take several instructions for a permutation (picks_from_vectors is false) always use scattered_corners.h.
#pragma once

#include <bit>
#include <cstdint>

#include "common/production_fluid/trace.h"
#include "common/simd.h"
#include "openmp/production_fluid/scattered_corners.h"

namespace lockstep::production_fluid {

// Loads corners in several fields, whose values begin at `origin`, each with cells of its own. The processor can hardly
// predict how many rounds there are; it mispredicts once for all fields if they share a loop.
template <int count>
LOCKSTEP_INLINE void load_line_corners(const float* const (&origin)[count], const Cell<intv> (&cells)[count],
                                       Corners<floatv> (&corners)[count]) {
  if constexpr (!picks_from_vectors) {
    for (int f = 0; f < count; ++f) corners[f] = ScatteredCorners()(origin[f], cells[f]);
    return;
  }
  constexpr int before = 4;  // so many cells before that of the first lane that is left are served with it
  alignas(64) std::int32_t first[count][lanes], to_line[count][lanes], to_plane[count][lanes];
  std::uint32_t left[count], any_left;
  for (int f = 0; f < count; ++f) {
    store(first[f], cells[f].first), store(to_line[f], cells[f].to_line), store(to_plane[f], cells[f].to_plane);
    left[f] = 0xffff;
  }
  do {
    any_left = 0;
    for (int f = 0; f < count; ++f) {
      // A field that has no lane left serves its last lane again.
      const int lane = std::countr_zero(left[f] | 0x8000), begin = first[f][lane] - before;
      // Between two lines is more padding than there are lanes, so these cells are of one line.
      const intv x = cells[f].first - begin;
      const maskv together = (x >= 0) & (x < lanes - 1);
      const auto take = [&](int line, const float* from) {
        const floatv values = load(from);
        where(together, corners[f].value[2 * line]) = permute(values, x);
        where(together, corners[f].value[2 * line + 1]) = permute(values, x + 1);
      };
      const float* const line = origin[f] + begin;
      const float* const next = line + to_line[f][lane];
      const std::int32_t plane = to_plane[f][lane];
      take(0, line), take(1, next), take(2, line + plane), take(3, next + plane);
      left[f] &= ~bits(together);
      any_left |= left[f];
    }
  } while (any_left);
}

// Loads the corners in a field, as sample() wants it; and tells velocity_at to load those of its three fields together.
struct LineCorners {
  LOCKSTEP_INLINE Corners<floatv> operator()(const float* field, const Cell<intv>& cell) const {
    Corners<floatv> corners[1];
    load_line_corners({field}, {cell}, corners);
    return corners[0];
  }
};

template <class Index>
inline Vector3<floatv> velocity_at(const Faces<float>& faces, const Vector3<floatv>& at, const LineCorners&) {
  const auto& [u, v, w] = faces;
  const Spot<floatv, Index> spots[] = {spot_of<Index>(u, first_u, at), spot_of<Index>(v, first_v, at),
                                       spot_of<Index>(w, first_w, at)};
  Corners<floatv> corners[3];
  load_line_corners({&u(0, 0, 0), &v(0, 0, 0), &w(0, 0, 0)}, {spots[0].cell, spots[1].cell, spots[2].cell}, corners);
  const auto component = [&](int k) {
    const auto& [x, y, z] = spots[k].along;
    return interpolate(corners[k], x, y, z);
  };
  return {component(0), component(1), component(2)};
}

}  // namespace lockstep::production_fluid
