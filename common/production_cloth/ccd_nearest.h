// The nearest points of a point and a triangle, and of two edges, for a number or for lanes. Vertex 0 is the origin.
//
// Degenerate elements have an answer, too: a triangle that is a line or a point, parallel edges, edges without length.
//
// Source: Ericson, Real-time collision detection, 2005, sections 5.1.5 and 5.1.9.
#pragma once

#include "common/production_cloth/ccd_filters.h"

namespace lockstep::production_cloth::meeting {

template <class V>
struct Nearest {
  Vector3<V> apart;  // from the second element's point to the first's
  V weight[4];       // as in contacts.h
};

// a / b within 0 .. 1; 0 where b is not positive.
template <class V>
inline V share_of(V a, V b) {
  return select(b > V(0.f), min(max(a / b, V(0.f)), V(1.f)), V(0.f));
}

// Edges from the origin to a, and from b to c. First, s is that of the two lines, clamped to its edge. Then t is
// nearest to the point s a on the second edge, and s nearest to that of t on the first. The last step corrects s where
// t had to be clamped; elsewhere it changes nothing.
template <class V>
inline Nearest<V> nearest_of_edges(const Vector3<V>& a, const Vector3<V>& b, const Vector3<V>& c) {
  const Vector3<V> e = c - b;
  const V aa = dot(a, a), ee = dot(e, e), ae = dot(a, e), ab = dot(a, b), eb = dot(e, b);
  V s = share_of(ab * ee - ae * eb, aa * ee - ae * ae);
  const V t = share_of(ae * s - eb, ee);
  s = share_of(ae * t + ab, aa);
  return {s * a - (b + t * e), {V(1.f) - s, s, t - V(1.f), -t}};
}

// The origin and the triangle (a, b, c): the nearest point of the three edges, or, where it is inside, of the plane.
template <class V>
inline Nearest<V> nearest_of_triangle(const Vector3<V>& a, const Vector3<V>& b, const Vector3<V>& c) {
  const Vector3<V>* corner[3] = {&a, &b, &c};
  Nearest<V> best = {};
  V best_2 = 0.f;
  for (int k = 0; k < 3; ++k) {
    const int l = (k + 1) % 3, m = (k + 2) % 3;
    const Vector3<V>& from = *corner[k];
    const Vector3<V> along = *corner[l] - from;
    const V s = share_of(-dot(along, from), dot(along, along));
    const Vector3<V> point = from + s * along;
    const V distance_2 = dot(point, point);
    const MaskOf<V> better = k == 0 ? distance_2 == distance_2 : distance_2 < best_2;
    best_2 = select(better, distance_2, best_2);
    best.apart = select(better, -point, best.apart);
    best.weight[1 + k] = select(better, s - V(1.f), best.weight[1 + k]);
    best.weight[1 + l] = select(better, -s, best.weight[1 + l]);
    best.weight[1 + m] = select(better, V(0.f), best.weight[1 + m]);
  }
  const Vector3<V> n = cross(b - a, c - a);
  const V nn = dot(n, n), of_a = dot(n, cross(b, c)), of_b = dot(n, cross(c, a)), of_c = nn - of_a - of_b;
  const MaskOf<V> inside = (of_a > V(0.f)) & (of_b > V(0.f)) & (of_c > V(0.f)) & (nn > V(0.f));
  best.apart = select(inside, -(dot(a, n) / nn) * n, best.apart);
  best.weight[0] = 1.f;
  best.weight[1] = select(inside, -(of_a / nn), best.weight[1]);
  best.weight[2] = select(inside, -(of_b / nn), best.weight[2]);
  best.weight[3] = select(inside, -(of_c / nn), best.weight[3]);
  return best;
}

template <Kind kind, class V>
inline Nearest<V> nearest(const Vector3<V> (&span)[3]) {
  if constexpr (kind == Kind::point_triangle)
    return nearest_of_triangle(span[0], span[1], span[2]);
  else
    return nearest_of_edges(span[0], span[1], span[2]);
}

// Whether the direction between the nearest points in the middle of the step keeps the elements apart from start to
// end. Any direction is valid, so that its rounding does not count.
template <Kind kind, class V>
inline MaskOf<V> apart_midway(const Spans<V>& spans) {
  Vector3<V> twice[3];
  for (int k = 0; k < 3; ++k) twice[k] = spans.start[k] + spans.end[k];
  return apart_along<kind>(spans, nearest<kind>(twice).apart, 1);
}

// Whether in each quarter of the step the vertices are never in one plane, or the elements are kept apart by the
// direction between the nearest points in the quarter's middle. That direction may be anything: it need not be exact.
// Spans within the step have two roundings more than those at its ends: of a product and of a sum.
template <Kind kind, class V>
inline MaskOf<V> apart_in_quarters(const Spans<V>& spans) {
  constexpr int span_roundings = 3;
  MaskOf<V> apart = V(0.f) == V(0.f);
  Spans<V> part = spans;
  for (int quarter = 1; quarter <= 4 && any(apart); ++quarter) {
    const float t = .25f * static_cast<float>(quarter);
    Vector3<V> twice[3];
    for (int k = 0; k < 3; ++k) {
      part.end[k] = quarter == 4 ? spans.end[k] : V(1.f - t) * spans.start[k] + V(t) * spans.end[k];
      twice[k] = part.start[k] + part.end[k];
    }
    apart &= apart_along<kind>(part, nearest<kind>(twice).apart, span_roundings) |
             never_in_plane(cubic_of(part), span_roundings);
    for (int k = 0; k < 3; ++k) part.start[k] = part.end[k];
  }
  return apart;
}

}  // namespace lockstep::production_cloth::meeting
