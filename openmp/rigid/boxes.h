// Boxes in lanes.
#pragma once

#include <span>

#include "common/rigid/bounds.h"
#include "common/simd.h"
#include "openmp/rigid/pair_list.h"

namespace lockstep::rigid::openmp {

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

// One box in every lane.
LOCKSTEP_INLINE Box<floatv> in_all_lanes(const Box<float>& box) {
  return {{box.low.x, box.low.y, box.low.z}, {box.high.x, box.high.y, box.high.z}};
}

LOCKSTEP_INLINE Box<floatv> select(maskv mask, const Box<floatv>& a, const Box<floatv>& b) {
  return {select(mask, a.low, b.low), select(mask, a.high, b.high)};
}

LOCKSTEP_INLINE maskv bounded(const Box<floatv>& box) { return box.low.x > -std::numeric_limits<float>::infinity(); }

// The box around sixteen.
LOCKSTEP_INLINE Box<float> around_lanes(const Box<floatv>& box) {
  return {{reduce_min(box.low.x), reduce_min(box.low.y), reduce_min(box.low.z)},
          {reduce_max(box.high.x), reduce_max(box.high.y), reduce_max(box.high.z)}};
}

// What stands in `order`, side by side.
inline const Arranged& arrange(const Bounds<float>& bounds, std::span<const std::int32_t> group, std::span<const std::int32_t> order) {
  const int n = static_cast<int>(order.size()), slots = static_cast<int>(padded(n));
  Arranged& sorted = workspace().arrange;
  sorted.count = n;
  sorted.boxes.resize(n);
  sorted.collider.resize(slots), sorted.group.resize(slots);
  // Every element is one thread's.
#pragma omp parallel for schedule(static)
  for (int k = 0; k < slots; ++k) {
    sorted.boxes.set(k, k < n ? bounds.box(order[k]) : empty_box<float>);
    if (k < n) sorted.collider[k] = order[k], sorted.group[k] = group[order[k]];
  }
  return sorted;
}

// Whose the boxes are, as pointers of its own: to the compiler, a pair that is stored could change those that the arrays hold.
struct Owners {
  const std::int32_t *collider, *group;
  explicit Owners(const Arranged& sorted) : collider(sorted.collider.data()), group(sorted.group.data()) {}
};

// Adds the pairs of box k with those of boxes j .. j + 15 that it hits and that are of other groups.
LOCKSTEP_INLINE void add_hits(const Owners& of, int k, int j, maskv hit, PairList& list) {
  const intv a = of.collider[k], b = load(of.collider + j);
  add(list, hit & (load(of.group + j) != of.group[k]), min(a, b), max(a, b));
}

}  // namespace lockstep::rigid::openmp
