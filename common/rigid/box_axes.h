// The separating axes of two boxes, for T a number or sixteen lanes. One pair stops at the first axis that separates
// it; sixteen go on, as they seldom all stop together.
#pragma once

#include <limits>
#include <type_traits>

#include "common/rigid/box_pair.h"
#include "common/rigid/truth.h"

namespace lockstep::rigid {

// Axes are numbered: a's faces 0 .. 2, b's 3 .. 5, then a's axis i x b's axis j, 6 + 3 i + j.
template <class T>
struct BoxAxis {
  Integer<T> number;
  T separation;
};

template <class T>
[[gnu::always_inline]] inline void keep_better(const Truth<T>& better, BoxAxis<T>& best, const BoxAxis<T>& other) {
  where(better, best.number) = other.number, where(better, best.separation) = other.separation;
}

template <class T>
inline constexpr bool stops_early = std::is_same_v<Truth<T>, bool>;

// Of the faces' axes the one of greatest separation, a's preferred to b's. Pairs that one separates by more than margin
// leave `active`.
template <class T>
[[gnu::always_inline]] inline BoxAxis<T> best_face(const BoxPair<T>& boxes, const T& margin, Truth<T>& active) {
  BoxAxis<T> best = {0, -std::numeric_limits<float>::infinity()}, best_b = best;
#pragma GCC unroll 3
  for (int i = 0; i < 3; ++i) {
    const T separation = face_separation_a(boxes, i);
    active = active & !(separation > margin);
    if (stops_early<T> && none(active)) return best;
    keep_better<T>(separation > best.separation, best, {i, separation});
  }
#pragma GCC unroll 3
  for (int j = 0; j < 3; ++j) {
    const T separation = face_separation_b(boxes, j);
    active = active & !(separation > margin);
    if (stops_early<T> && none(active)) return best;
    keep_better<T>(separation > best_b.separation, best_b, {3 + j, separation});
  }
  keep_better<T>(best_b.separation > best.separation + T(axis_preference) * largest_half(boxes), best, best_b);
  return best;
}

// The same for the edges' axes and the axis of a face; the face's is preferred.
template <class T>
[[gnu::always_inline]] inline BoxAxis<T> best_axis(const BoxPair<T>& boxes, const T& margin, BoxAxis<T> face,
                                                   Truth<T>& active) {
  BoxAxis<T> best = {0, -std::numeric_limits<float>::infinity()};
#pragma GCC unroll 3
  for (int i = 0; i < 3; ++i)
#pragma GCC unroll 3
    for (int j = 0; j < 3; ++j) {
      const T sine_2 = edge_sine_2(boxes, i, j);
      const Truth<T> turned = !(sine_2 <= T(parallel_sine_2));
      if (stops_early<T> && none(turned)) continue;
      const T separation = edge_separation(boxes, i, j, sine_2);
      active = active & !(turned & (separation > margin));
      if (stops_early<T> && none(active)) return best;
      keep_better<T>(turned & (separation > best.separation), best, {6 + 3 * i + j, separation});
    }
  keep_better<T>(best.separation > face.separation + T(axis_preference) * largest_half(boxes), face, best);
  return face;
}

// Of the edges' axis of that number, a's axis; of others, some axis.
template <class I>
[[gnu::always_inline]] inline I axis_a(const I& number) {
  return select(number >= I(12), I(2), select(number >= I(9), I(1), I(0)));
}

// The axis after i.
template <class I>
[[gnu::always_inline]] inline I next(const I& i) {
  return select(i == I(2), I(0), i + I(1));
}

// a's axis i x b's axis j, of length 1, from a to b, along a's axes.
template <class T, class I>
[[gnu::always_inline]] inline Three<T> edge_normal(const BoxPair<T>& boxes, const I& i, const I& j) {
  const auto& [half_a, half_b, t, r] = boxes;
  const T zero(0);
  const Three<T> c = {r[0][j], r[1][j], r[2][j]};
  const Three<T> n = {select(i == I(0), zero, select(i == I(1), c[2], -c[1])),
                      select(i == I(1), zero, select(i == I(2), c[0], -c[2])),
                      select(i == I(2), zero, select(i == I(0), c[1], -c[0]))};
  const T length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  const T scale = select(t[0] * n[0] + t[1] * n[1] + t[2] * n[2] < zero, T(-1), T(1)) / length;
  return {scale * n[0], scale * n[1], scale * n[2]};
}

// Which of three is the longest, the first of equals.
template <class T>
[[gnu::always_inline]] inline Integer<T> longest(const Three<T>& v) {
  using I = Integer<T>;
  const I i = select(abs(v[1]) > abs(v[0]), I(1), I(0));
  return select(abs(v[2]) > max(abs(v[0]), abs(v[1])), I(2), i);
}

// The face against which one of the other box is clipped.
template <class T>
struct ReferenceFace {
  Truth<T> on_b;    // whether it is b's
  Integer<T> axis;  // of its box
  Three<T> normal;  // along the axes of its box, out of it
};

// The face whose axis won. number: of the axis, below 6. Lanes whose number is of two edges get a face of a, which
// means nothing.
template <class T, class I>
[[gnu::always_inline]] inline ReferenceFace<T> winning_face(const BoxPair<T>& boxes, const I& number) {
  const Truth<T> on_b = (number >= I(3)) & (number < I(6));
  const I axis = select(on_b, number - I(3), number);
  const T offset = select(on_b, -along_b(boxes, boxes.offset)[axis], boxes.offset[axis]), zero(0);
  const T sign = select(offset < zero, T(-1), T(1));
  return {on_b,
          axis,
          {select(axis == I(0), sign, zero), select(axis == I(1), sign, zero), select(axis == I(2), sign, zero)}};
}

// The face that is clipped where two edges won. Of each box one face is nearest to flush with the edges' normal. It is
// a's if that is within flush_cosine of flush, or else b's. normal: of the edges, from a to b, along a's axes;
// normal_b: the same along b's axes. flush: whether the face is within flush_cosine. Where it is not, the edges touch
// in one point.
template <class T>
[[gnu::always_inline]] inline ReferenceFace<T> flush_face(const Three<T>& normal, const Three<T>& normal_b,
                                                          Truth<T>& flush) {
  const Integer<T> axis_a = longest(normal), axis_b = longest(normal_b);
  const Truth<T> on_b = abs(normal[axis_a]) < T(flush_cosine);
  flush = (!on_b) | (abs(normal_b[axis_b]) >= T(flush_cosine));
  return {on_b, select(on_b, axis_b, axis_a), select(on_b, opposite(normal_b), normal)};
}

}  // namespace lockstep::rigid
