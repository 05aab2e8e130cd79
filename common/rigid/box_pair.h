// Two boxes, seen from the first, and the formulas of box against box, for T a scalar or sixteen lanes.
//
// Bounds, all relative to the larger box's largest half side, `size` (u = 2^-24, the rounding of float). A separation
// sums some eight products of numbers up to size: it is good to 10 u size = 6e-7 size, and axis_preference covers that.
// Everything follows from it:
//
//   - An axis replaces the one that is preferred to it only if it is better by axis_preference: so the depth is that of
//     the best axis to within axis_preference, and rounding does not choose.
//   - The axis of two edges at an angle is at most 2 half sin(angle) better than the best of the others: the face of
//     the boxes' difference that it belongs to is a strip of that width, and beyond either side of the strip is one of
//     the others. Where that is less than axis_preference it cannot win, so edges of sin(angle) <= axis_preference / 2
//     need no test.
//   - The lowest corner of the other box may lie beside the reference face where another axis is better by b <=
//     axis_preference + rounding. Within the prism over the face the other box still reaches down to depth - b (were it
//     less, moving the boxes apart by less than the true depth would part them). If that point is not on the incident
//     face, then on a neighbour of it, at most b above the lowest corner; the edge that leads there from the incident
//     face rises by at least 1 / sqrt(3) of its length. So the incident face is at most 1.42 b beside the prism at that
//     depth: the reference face, widened by 2 b, always meets it. face_widening is 2 b.
#pragma once

#include "common/math.h"
#include "common/rigid/rotation.h"
#include "common/rigid/world.h"

namespace lockstep::rigid {

inline constexpr float axis_preference = 1e-6f;
inline constexpr float parallel_sine_2 = .25f * axis_preference * axis_preference;
inline constexpr float face_widening = 4e-6f;
// Points nearer than this give the same point: a corner found on both faces is found twice, face_widening apart in x
// and in y at most, and in an angle of the clipped polygon, which is not below 35 degrees where two corners meet, 1.75
// times that.
inline constexpr float same_point = 1e-5f;
// cos 8 degrees. Where two edges win but a face beside one of them is at most this far from the normal, faces are
// clipped: that face against the one of the other box that is most nearly opposite. Off by more, two faces part so fast
// that points farther than margin / tan 8 = 7 margins from the deepest are no contacts in any case. A box at rest is
// out of flush by about a margin or less, far below this angle.
inline constexpr float flush_cosine = .990268f;

using lockstep::select;  // not hidden by those below

// Three values by number. Where the number is lanes, each lane gets its own.
template <class T>
struct Three {
  T value[3];
  [[gnu::always_inline]] T& operator[](int i) { return value[i]; }
  [[gnu::always_inline]] const T& operator[](int i) const { return value[i]; }
  template <class Index>
  [[gnu::always_inline]] T operator[](const Index& i) const {
    return select(i == Index(2), value[2], select(i == Index(1), value[1], value[0]));
  }
};

template <class Mask, class T>
[[gnu::always_inline]] inline Three<T> select(const Mask& mask, const Three<T>& a, const Three<T>& b) {
  return {select(mask, a[0], b[0]), select(mask, a[1], b[1]), select(mask, a[2], b[2])};
}

template <class T>
[[gnu::always_inline]] inline Three<T> opposite(const Three<T>& v) {
  return {-v[0], -v[1], -v[2]};
}

template <class T>
struct BoxPair {
  Three<T> half_a, half_b;  // m
  Three<T> offset;          // of b's centre from a's, along a's axes, m
  Three<Three<T>> turn;     // [i][j]: b's axis j along a's axis i
};

// In the frame of a, so that it does not matter where in the world the boxes are.
template <class T>
[[gnu::always_inline]] inline BoxPair<T> box_pair(const Vector3<T>& position_a, const Quaternion<T>& orientation_a,
                                                  const Quad<T>& half_a, const Vector3<T>& position_b,
                                                  const Quaternion<T>& orientation_b, const Quad<T>& half_b) {
  const Vector3<T> t = transposed_times(matrix_of(orientation_a), position_b - position_a);
  const Matrix3<T> r = matrix_of(conjugate(orientation_a) * orientation_b);
  return {{half_a.x, half_a.y, half_a.z},
          {half_b.x, half_b.y, half_b.z},
          {t.x, t.y, t.z},
          {{{r.x.x, r.y.x, r.z.x}, {r.x.y, r.y.y, r.z.y}, {r.x.z, r.y.z, r.z.z}}}};
}

// The largest half side of both.
template <class T>
[[gnu::always_inline]] inline T largest_half(const BoxPair<T>& boxes) {
  const Three<T>&a = boxes.half_a, &b = boxes.half_b;
  return max(max(max(a[0], a[1]), a[2]), max(max(b[0], b[1]), b[2]));
}

// A vector along a's axes, along b's.
template <class T>
[[gnu::always_inline]] inline Three<T> along_b(const BoxPair<T>& boxes, const Three<T>& v) {
  const auto& r = boxes.turn;
  return {v[0] * r[0][0] + v[1] * r[1][0] + v[2] * r[2][0], v[0] * r[0][1] + v[1] * r[1][1] + v[2] * r[2][1],
          v[0] * r[0][2] + v[1] * r[1][2] + v[2] * r[2][2]};
}

// How far b reaches along a's axis i, and a along b's axis j.
template <class T, class Index>
[[gnu::always_inline]] inline T reach_of_b(const BoxPair<T>& boxes, const Index& i) {
  const auto& [half_a, half_b, t, r] = boxes;
  const Three<T> row = r[i];
  return half_b[0] * abs(row[0]) + half_b[1] * abs(row[1]) + half_b[2] * abs(row[2]);
}
template <class T>
[[gnu::always_inline]] inline T reach_of_a(const BoxPair<T>& boxes, int j) {
  const auto& [half_a, half_b, t, r] = boxes;
  return half_a[0] * abs(r[0][j]) + half_a[1] * abs(r[1][j]) + half_a[2] * abs(r[2][j]);
}

// Separations along a's axis i and b's axis j, which faces are across.
template <class T>
[[gnu::always_inline]] inline T face_separation_a(const BoxPair<T>& boxes, int i) {
  return abs(boxes.offset[i]) - (boxes.half_a[i] + reach_of_b(boxes, i));
}
template <class T>
[[gnu::always_inline]] inline T face_separation_b(const BoxPair<T>& boxes, int j) {
  const auto& [half_a, half_b, t, r] = boxes;
  return abs(t[0] * r[0][j] + t[1] * r[1][j] + t[2] * r[2][j]) - (half_b[j] + reach_of_a(boxes, j));
}

// sin^2 of the angle between a's axis i and b's axis j; from the sine, which does not cancel where that is small.
template <class T>
[[gnu::always_inline]] inline T edge_sine_2(const BoxPair<T>& boxes, int i, int j) {
  const T &r1 = boxes.turn[(i + 1) % 3][j], &r2 = boxes.turn[(i + 2) % 3][j];
  return r1 * r1 + r2 * r2;
}

// Separation along a's axis i x b's axis j = (0, -r2, r1), sine long. How far b reaches along it is computed from that
// very vector, by the minors of turn, and not from the entry of turn that a minor of a rotation should equal: the
// rounding of either is u, which the sine would divide, but here the vector and what is measured along it are off
// together, and every vector gives a true bound.
template <class T>
[[gnu::always_inline]] inline T edge_separation(const BoxPair<T>& boxes, int i, int j, const T& sine_2) {
  const auto& [half_a, half_b, t, r] = boxes;
  const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
  const T minor1 = r[i1][j] * r[i2][j1] - r[i2][j] * r[i1][j1], minor2 = r[i1][j] * r[i2][j2] - r[i2][j] * r[i1][j2];
  const T reach_a = half_a[i1] * abs(r[i2][j]) + half_a[i2] * abs(r[i1][j]);
  const T reach_b = half_b[j1] * abs(minor1) + half_b[j2] * abs(minor2);
  return (abs(t[i2] * r[i1][j] - t[i1] * r[i2][j]) - (reach_a + reach_b)) / sqrt(sine_2);
}

// b and a.
template <class T>
[[gnu::always_inline]] inline BoxPair<T> swapped(const BoxPair<T>& boxes) {
  const auto& [half_a, half_b, t, r] = boxes;
  const Three<T> back = along_b(boxes, t);
  return {half_b,
          half_a,
          {-back[0], -back[1], -back[2]},
          {{{r[0][0], r[1][0], r[2][0]}, {r[0][1], r[1][1], r[2][1]}, {r[0][2], r[1][2], r[2][2]}}}};
}

template <class Mask, class T>
[[gnu::always_inline]] inline BoxPair<T> select(const Mask& mask, const BoxPair<T>& a, const BoxPair<T>& b) {
  const auto &r = a.turn, &s = b.turn;
  return {select(mask, a.half_a, b.half_a),
          select(mask, a.half_b, b.half_b),
          select(mask, a.offset, b.offset),
          {{select(mask, r[0], s[0]), select(mask, r[1], s[1]), select(mask, r[2], s[2])}}};
}

// What contacts come from, in numbers: faces of the pair are numbered 0 .. 11 (2 axis + 1 on the positive side; b's
// from 6 on), edges of a box 0 .. 11 (4 axis, + 1 and + 2 on the positive side of the next axis and the one after). The
// candidates of two faces have slots: 2 k and 2 k + 1, edge k of the incident face; 8 + k, corner k of the reference
// face; 12, the incident face's deepest corner.
inline constexpr int slots = 13;
inline constexpr int first_edge_feature = 12 * 6 * slots;

}  // namespace lockstep::rigid
