// Which kernel of the narrow phase a pair of kinds goes to. A kernel's pairs are sorted by kinds, too, so that like
// ones stand together.
#pragma once

#include <array>
#include <vector>

#include "common/rigid/pairs.h"
#include "common/rigid/round.h"
#include "common/rigid/world.h"

namespace lockstep::rigid {

// Bins in order: of spheres, one a form; of planes, one a kind of convex; box_box; convexes.
inline constexpr int first_of_spheres = 0, first_of_planes = first_of_spheres + round_forms,
                     first_of_box_box = first_of_planes + kinds - 1, first_of_convexes = first_of_box_box + 1,
                     bins = first_of_convexes + 1;

inline int bin_of(Kind a, Kind b) {
  if (a == Kind::plane || b == Kind::plane) return first_of_planes + static_cast<int>(a == Kind::plane ? b : a);
  if (a == Kind::box && b == Kind::box) return first_of_box_box;
  if (a > Kind::box || b > Kind::box) return first_of_convexes;
  return first_of_spheres + static_cast<int>(round_form(a, b));
}

template <class Real>
inline int bin_of_pair(const Colliders<Real>& colliders, const Pair& pair) {
  return bin_of(static_cast<Kind>(colliders.kind[pair.a]), static_cast<Kind>(colliders.kind[pair.b]));
}

// Pairs by bins: bin b has those from first[b] to first[b + 1] - 1. Within a bin they are in order.
struct SortedPairs {
  Pairs pairs;
  std::vector<int> place;  // of each pair before it was sorted
  std::array<int, bins + 1> first;
};

}  // namespace lockstep::rigid
