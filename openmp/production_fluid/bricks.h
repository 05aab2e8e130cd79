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

// For each line of cells and each brick along it, the value that all points of the line have that are in the brick or
// beside it; NaN where they differ. Lines are read from end to end, which the processor foresees better than the short
// lines of a brick.
class CommonValues {
 public:
  // Of a line and brick k, f(y, z, k) is that value. There is a line more along y and z, for faces.
  template <class F>
  CommonValues(int ny, int nz, int along_x, const F& f)
      : ny_(ny + 1), nz_(nz + 1), along_x_(along_x), values_(std::size_t(ny_) * nz_ * along_x) {
    // A line writes its own values.
#pragma omp parallel for collapse(2) schedule(static)
    for (int z = 0; z < nz_; ++z)
      for (int y = 0; y < ny_; ++y)
        for (int k = 0; k < along_x_; ++k) values_[at(y, z) + k] = f(y, z, k);
  }
  // Whether all points of brick k and those beside it have a value.
  bool all_are(float value, const Box& brick, int k) const {
    const Box near = around(brick);
    for (int z = std::max(near.z.begin, 0); z < std::min(near.z.end, nz_); ++z)
      for (int y = std::max(near.y.begin, 0); y < std::min(near.y.end, ny_); ++y)
        if (values_[at(y, z) + k] != value) return false;
    return true;
  }

 private:
  std::size_t at(int y, int z) const { return (std::size_t(z) * ny_ + y) * along_x_; }

  int ny_, nz_, along_x_;
  Array<float> values_;
};

// The value that points 16 k - 1 .. 16 k + 16 of a field's line have in common; NaN if they differ.
LOCKSTEP_INLINE float common_value(const Field<float>& field, int y, int z, int k) {
  const int x = k * lanes;
  const float* const at = &field(x, y, z);
  const bool all_are = none(first_lanes(field.nx - x) & (load(at) != *at)) && (x == 0 || at[-1] == *at) &&
                       (x + lanes >= field.nx || at[lanes] == *at);
  return all_are ? *at : std::numeric_limits<float>::quiet_NaN();
}

inline void fill(Field<float>& field, const Box& box, float value) {
  const auto [along_x, along_y, along_z] = inside(field, box);
  for (int z = along_z.begin; z < along_z.end; ++z)
    for (int y = along_y.begin; y < along_y.end; ++y)
      for (int x = along_x.begin; x < along_x.end; x += lanes)
        store(&field(x, y, z), floatv(value), first_lanes(along_x.end - x));
}

}  // namespace lockstep::production_fluid::openmp
