// The feet of a line's points, sixteen at a time.
#pragma once

#include <algorithm>

#include "common/production_fluid/bricks.h"
#include "common/simd.h"
#include "common/vector3.h"
#include "openmp/production_fluid/bricks.h"

namespace lockstep::production_fluid::openmp {

// Calls f(x, inside, foot) for sixteen points of a span at a time; `inside` marks those in the span, foot is what
// foot_at(x) gave. A trace has some 600 instructions that wait for one another, more than the processor looks ahead. So
// the feet of up to eight vectors are found before f uses the first.
template <class FootAt, class F>
LOCKSTEP_INLINE void for_each_foot_of_line(const Span& along_x, const FootAt& foot_at, const F& f) {
  constexpr int together = 8;
  for (int begin = along_x.begin; begin < along_x.end; begin += together * lanes) {
    Vector3<floatv> foot[together];
    const int end = std::min(begin + together * lanes, along_x.end);
    for (int x = begin, k = 0; x < end; x += lanes, ++k) foot[k] = foot_at(first_of_full(x, along_x.end));
    for (int next = begin, k = 0; next < end; next += lanes, ++k) {
      const int x = first_of_full(next, along_x.end);
      f(x, is_in(along_x, x + lane_index()), foot[k]);
    }
  }
}

// The line of a field that advection comes to a row of bricks later; feet reach one line further than the row. Lines
// are short and far apart in memory, so that the processor does not foresee them, and what is used is prefetched there.
inline int line_ahead(const Field<float>& field, int y) { return std::min(y + 5, field.ny - 1); }

}  // namespace lockstep::production_fluid::openmp
