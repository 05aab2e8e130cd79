// Sixteen boxes at a time.
#pragma once

#include "common/simd.h"
#include "common/spatial/bounds.h"

namespace lockstep::spatial::openmp {

// Boxes i .. i + 15.
LOCKSTEP_INLINE Box<floatv> load_boxes(const Bounds<float>& bounds, int i) {
  const Vectors<float>&low = bounds.low, &high = bounds.high;
  return {{load(&low.x[i]), load(&low.y[i]), load(&low.z[i])}, {load(&high.x[i]), load(&high.y[i]), load(&high.z[i])}};
}

LOCKSTEP_INLINE void store_boxes(Bounds<float>& bounds, int i, const Box<floatv>& box) {
  Vectors<float>&low = bounds.low, &high = bounds.high;
  store(&low.x[i], box.low.x), store(&low.y[i], box.low.y), store(&low.z[i], box.low.z);
  store(&high.x[i], box.high.x), store(&high.y[i], box.high.y), store(&high.z[i], box.high.z);
}

// The same box in every lane.
LOCKSTEP_INLINE Box<floatv> in_all_lanes(const Box<float>& box) {
  return {{box.low.x, box.low.y, box.low.z}, {box.high.x, box.high.y, box.high.z}};
}

LOCKSTEP_INLINE Box<floatv> select(maskv mask, const Box<floatv>& a, const Box<floatv>& b) {
  return {select(mask, a.low, b.low), select(mask, a.high, b.high)};
}

LOCKSTEP_INLINE maskv bounded(const Box<floatv>& box) { return box.low.x > -std::numeric_limits<float>::infinity(); }

// Which of sixteen boxes overlap their partners, as `overlap` of common/spatial/bounds.h, by the signs of differences:
// on a Zen 4 six comparisons, whose results are masks, take half as long again. No number may be NaN, and no upper end
// -0, from which +0 is -0.
LOCKSTEP_INLINE maskv overlap_by_signs(const Box<floatv>& a, const Box<floatv>& b) {
  const auto ends = [](const Vector3<floatv>& high, const Vector3<floatv>& low) {
    const Vector3<floatv> room = high - low;
    return bits_of(room.x) | bits_of(room.y) | bits_of(room.z);
  };
  return (ends(a.high, b.low) | ends(b.high, a.low)) >= 0;
}

// The smallest box around sixteen.
LOCKSTEP_INLINE Box<float> around_lanes(const Box<floatv>& box) {
  return {{reduce_min(box.low.x), reduce_min(box.low.y), reduce_min(box.low.z)},
          {reduce_max(box.high.x), reduce_max(box.high.y), reduce_max(box.high.z)}};
}

}  // namespace lockstep::spatial::openmp
