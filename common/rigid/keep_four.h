// Contact points, reduced to four: the deepest; the farthest from it; and the farthest to either side of the line
// through both. These hold two colliders apart about as all of them would. For T a number or sixteen lanes.
//
// `points` says which candidates there are, and how they are measured:
//   Point                    has a `separation`; take(mask, from, to) copies one where the mask is true
//   each(action)             calls action(point, valid) for each candidate, in order; between find_deepest and
//                            find_others, a kernel may narrow down which are valid
//   deeper_by()              a point replaces the deepest one before it only if it is deeper by more than this
//   distance_2(p, deepest)   squared distance
//   least_distance_2()       the value that it must exceed
//   side(deepest, farthest)  a function of a point: the area that it spans with both, positive on the left
//   least_side(distance_2)   the value that an area must exceed on either side, given the squared distance of the
//                            farthest
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
  constexpr float infinity = std::numeric_limits<float>::infinity();
  Kept<T, typename Points::Point> deepest = {all_false<T>(), {}};
  T least = infinity;
  points.each([&](const auto& p, const Truth<T>& valid) __attribute__((always_inline)) {
    const Truth<T> better = valid & (p.separation < least - points.deeper_by());
    where(better, least) = p.separation;
    take(better, p, deepest.point);
  });
  deepest.there = least < T(infinity);
  return deepest;
}

template <class T, class Point>
struct Four {
  Kept<T, Point> deepest, farthest, left, right;
  T most_left, most_right;  // the areas of the points to either side
};
template <class T, class Points>
[[gnu::always_inline]] inline auto find_others(const Points& points, const Kept<T, typename Points::Point>& deepest) {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  typename Points::Point farthest{}, left{}, right{};

  const T least_distance_2 = select(deepest.there, points.least_distance_2(), T(infinity));
  T most = least_distance_2;
  points.each([&](const auto& p, const Truth<T>& valid) __attribute__((always_inline)) {
    const T distance_2 = points.distance_2(p, deepest.point);
    const Truth<T> better = valid & (distance_2 > most);
    where(better, most) = distance_2;
    take(better, p, farthest);
  });
  const Truth<T> two = most > least_distance_2;
  const Kept<T, typename Points::Point> none_yet{all_false<T>(), left};
  if (none(two)) return Four<T, typename Points::Point>{deepest, none_yet, none_yet, none_yet, T(0), T(0)};

  const auto side = points.side(deepest.point, farthest);
  const T least_side = select(two, points.least_side(most), T(infinity));
  T leftmost = least_side, rightmost = -least_side;
  points.each([&](const auto& p, const Truth<T>& valid) __attribute__((always_inline)) {
    const T area = side(p);
    const Truth<T> is_left = valid & (area > leftmost), is_right = valid & (area < rightmost);
    where(is_left, leftmost) = area, where(is_right, rightmost) = area;
    take(is_left, p, left), take(is_right, p, right);
  });
  return Four<T, typename Points::Point>{
      deepest, {two, farthest}, {leftmost > least_side, left}, {rightmost < -least_side, right}, leftmost, -rightmost};
}

}  // namespace lockstep::rigid
