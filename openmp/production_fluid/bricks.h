// What advection asks of whole bricks (common/production_fluid/bricks.h), a vector at a time.
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>

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

// For each line of a field and each brick along it, the value that all points of the line have that are in the brick or
// beside it; NaN where they differ. Lines are read from end to end, which the processor foresees better than the short
// lines of a brick.
class CommonValues {
 public:
  explicit CommonValues(const Field<float>& field)
      : ny_(field.ny),
        nz_(field.nz),
        along_x_((field.nx + lanes - 1) / lanes),
        values_(std::size_t(ny_) * nz_ * along_x_) {
    // A line writes its own values.
#pragma omp parallel for collapse(2) schedule(static)
    for (int z = 0; z < nz_; ++z)
      for (int y = 0; y < ny_; ++y)
        for (int k = 0; k < along_x_; ++k) values_[at(y, z) + k] = common_value(&field(k * lanes, y, z), k, field.nx);
  }
  // Whether the points of each line of a brick and of those beside it have a value in common of which `holds` is true.
  // `near` is around the brick.
  template <class Predicate>
  friend bool all_in(const CommonValues& values, const Box& near, const Predicate& holds) {
    const int k = (near.x.begin + 1) / lanes;
    for (int z = std::max(near.z.begin, 0); z < std::min(near.z.end, values.nz_); ++z)
      for (int y = std::max(near.y.begin, 0); y < std::min(near.y.end, values.ny_); ++y)
        if (!holds(values.values_[values.at(y, z) + k])) return false;
    return true;
  }

 private:
  // Of points 16 k - 1 .. 16 k + 16 of a line of n; `p` is at 16 k.
  static float common_value(const float* p, int k, int n) {
    const bool all_are = none(first_lanes(n - k * lanes) & (load(p) != *p)) && (k == 0 || p[-1] == *p) &&
                         ((k + 1) * lanes >= n || p[lanes] == *p);
    return all_are ? *p : std::numeric_limits<float>::quiet_NaN();
  }
  std::size_t at(int y, int z) const { return (std::size_t(z) * ny_ + y) * along_x_; }

  int ny_, nz_, along_x_;
  Array<float> values_;
};

inline void fill(Field<float>& field, const Box& box, float value) {
  const auto [along_x, along_y, along_z] = inside(field, box);
  for (int z = along_z.begin; z < along_z.end; ++z)
    for (int y = along_y.begin; y < along_y.end; ++y)
      for (int x = along_x.begin; x < along_x.end; x += lanes)
        store(&field(x, y, z), floatv(value), first_lanes(along_x.end - x));
}

}  // namespace lockstep::production_fluid::openmp
