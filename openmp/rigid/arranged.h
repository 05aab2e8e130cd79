// Boxes side by side in some order, with the numbers and groups of their colliders.
#pragma once

#include <algorithm>
#include <span>

#include "common/rigid/place_colliders.h"
#include "common/simd.h"
#include "openmp/spatial/pair_list.h"

namespace lockstep::rigid::openmp {

// Sixteen elements may be loaded from any element on. Boxes beyond the last are empty.
struct Arranged {
  int count = 0;
  Bounds<float> boxes;
  Array<std::int32_t> collider, group;
};

// The colliders that stand in `order`. The calling thread's own, kept from call to call (openmp/spatial/workspace.h
// says why).
inline const Arranged& arrange(const Bounds<float>& bounds, std::span<const std::int32_t> group,
                               std::span<const std::int32_t> order) {
  thread_local Arranged kept;
  Arranged& sorted = kept;  // the team's threads would each see their own `kept`
  const int n = static_cast<int>(order.size()), slots = static_cast<int>(padded(n));
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

// Local copies of the array pointers: otherwise the compiler must reload them after every store (aliasing).
struct Owners {
  const std::int32_t *collider, *group;
  explicit Owners(const Arranged& sorted) : collider(sorted.collider.data()), group(sorted.group.data()) {}
};

// Adds the pairs of box k and those of boxes j .. j + 15 that it hits and that are of other groups.
LOCKSTEP_INLINE void add_hits(const Owners& of, int k, int j, maskv hit, spatial::openmp::PairList& list) {
  const intv a = of.collider[k], b = load(of.collider + j);
  add(list, hit & (load(of.group + j) != of.group[k]), min(a, b), max(a, b));
}

}  // namespace lockstep::rigid::openmp
