// Contact points, reduced to four: the deepest; the farthest from it; and the farthest to either side of the line
// through both. These hold two colliders apart about as all of them would. For T a number or sixteen lanes.
//
// `points` says which candidates there are, and how they are measured:
//   Point                    has a `separation`; take(mask, from, to) copies one where the mask is true
//   each(action)             calls action(point, valid) for each candidate, in order; between find_deepest and find_others, a kernel
//                            may narrow down which are valid
//   deeper_by()              a point replaces the deepest one before it only if it is deeper by more than this
//   distance_2(p, deepest)   squared distance
//   least_distance_2()       the value that it must exceed
//   side(deepest, farthest)  a function of a point: the area that it spans with both, positive on the left
//   least_side(distance_2)   the value that an area must exceed on either side, given the squared distance of the farthest
// Of equals the first is kept.
#pragma once

#include <limits>

#include "common/rigid/truth.h"

namespace lockstep::rigid {

// A point, and whether there is one.
template <class T, class Point>
struct Kept {
  Truth<T> there;
  Point point;
};

template <class T, class Points>
[[gnu::always_inline]] inline auto find_deepest(const Points& points) {
  Kept<T, typename Points::Point> deepest = {all_false<T>(), {}};
  T least = std::numeric_limits<float>::infinity();
  points.each([&](const auto& p, const Truth<T>& valid) __attribute__((always_inline)) {
    const Truth<T> better = valid & (p.separation < least - points.deeper_by());
    where(better, least) = p.separation;
    take(better, p, deepest.point);
  });
  deepest.there = least < std::numeric_limits<float>::infinity();
  return deepest;
}

template <class T, class Point>
struct Four {
  Kept<T, Point> deepest, farthest, left, right;
  T most_left, most_right;  // the areas of the points to either side
};
template <class T, class Points>
[[gnu::always_inline]] inline auto find_others(const Points& points, const Kept<T, typename Points::Point>& deepest) {
  const Kept<T, typename Points::Point> none_yet = {all_false<T>(), {}};
  Four<T, typename Points::Point> four = {deepest, none_yet, none_yet, none_yet, T(0), T(0)};
  auto &farthest = four.farthest, &left = four.left, &right = four.right;
  T &most_left = four.most_left, &most_right = four.most_right;

  T most = points.least_distance_2();
  points.each([&](const auto& p, const Truth<T>& valid) __attribute__((always_inline)) {
    const T distance_2 = points.distance_2(p, deepest.point);
    const Truth<T> better = deepest.there & valid & (distance_2 > most);
    where(better, most) = distance_2;
    take(better, p, farthest.point);
  });
  farthest.there = most > points.least_distance_2();
  if (none(farthest.there)) return four;

  const auto side = points.side(deepest.point, farthest.point);
  const T least_side = points.least_side(most);
  most_left = most_right = least_side;
  points.each([&](const auto& p, const Truth<T>& valid) __attribute__((always_inline)) {
    const T area = side(p);
    const Truth<T> usable = farthest.there & valid;
    const Truth<T> is_left = usable & (area > most_left), is_right = usable & (-area > most_right);
    where(is_left, most_left) = area, where(is_right, most_right) = -area;
    take(is_left, p, left.point), take(is_right, p, right.point);
  });
  left.there = most_left > least_side, right.there = most_right > least_side;
  return four;
}

}  // namespace lockstep::rigid
