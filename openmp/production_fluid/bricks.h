// What advection asks of whole bricks (common/production_fluid/bricks.h), a vector at a time.
#pragma once

#include <algorithm>

#include "common/production_fluid/bricks.h"
#include "common/simd.h"

namespace lockstep::production_fluid::openmp {

// The first of sixteen of n elements that are computed at once for `begin`. At the end of a line it lies before
// `begin`, so that no lane is beyond the end unless there are fewer elements than lanes.
inline int first_of_full(int begin, int n) { return std::max(0, std::min(begin, n - lanes)); }

// Which points of a line are in a span.
LOCKSTEP_INLINE maskv is_in(const Span& span, const intv& x) { return (x >= span.begin) & (x < span.end); }

// Whether `holds` is true of all of a field's values in a box. Values beside the box may be tested, too: a false answer
// only costs a trace.
template <class Predicate>
LOCKSTEP_INLINE bool all_in(const Field<float>& field, const Box& box, const Predicate& holds) {
  const auto [along_x, along_y, along_z] = inside(field, box);
  for (int z = along_z.begin; z < along_z.end; ++z)
    for (int y = along_y.begin; y < along_y.end; ++y)
      for (int x = along_x.begin; x < along_x.end; x += lanes)
        if (!all(holds(load(&field(first_of_full(x, along_x.end), y, z))))) return false;
  return true;
}

inline void fill(Field<float>& field, const Box& box, float value) {
  const auto [along_x, along_y, along_z] = inside(field, box);
  for (int z = along_z.begin; z < along_z.end; ++z)
    for (int y = along_y.begin; y < along_y.end; ++y)
      for (int x = along_x.begin; x < along_x.end; x += lanes)
        store(&field(x, y, z), floatv(value), first_lanes(along_x.end - x));
}

}  // namespace lockstep::production_fluid::openmp
