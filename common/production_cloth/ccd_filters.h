// Tests that tell of most pairs that they do not meet within a step, for a number or for lanes. They never dismiss a
// pair that meets: comparisons are exact, and sums must exceed a bound of their rounding.
//
// Relative positions of two vertices are linear in time. So a quantity that is linear in them, and positive at both
// ends, is positive throughout. A product of three such quantities is a cubic of time.
//
// Rounding. u is half the distance of 1 to the next number. A difference of coordinates rounds once: its relative error
// is u at most. Then a sum of products in which no term goes through more than k roundings is wrong by at most
// k u / (1 - k u) times the sum of the terms' magnitudes; what products lose to underflow comes on top (`least`).
#pragma once

#include <type_traits>
#include <utility>

#include "common/math.h"
#include "common/vector3.h"

namespace lockstep::production_cloth::meeting {

// Vertices 0 .. first_of<kind> - 1 are those of the pair's first element, the others those of the second.
enum class Kind { point_triangle, edge_edge };
template <Kind kind>
inline constexpr int first_of = kind == Kind::point_triangle ? 1 : 2;

template <class V>
using MaskOf = decltype(std::declval<V>() < std::declval<V>());

// A pair's vertices.
template <class V>
struct Corners {
  Vector3<V> start[4], end[4];
};

// --- Along a coordinate axis: at the start and at the end, the first element is on the same side of the second. Swept
// boxes would dismiss no more: where they are disjoint along an axis, so are extents at both ends, on the same side.

template <class V>
struct Range {
  V least, greatest;
};
template <class V>
inline Range<V> range_of(const Vector3<V>* x, V Vector3<V>::*component, int from, int to) {
  Range<V> range = {x[from].*component, x[from].*component};
  for (int i = from + 1; i < to; ++i) range = {min(range.least, x[i].*component), max(range.greatest, x[i].*component)};
  return range;
}

template <Kind kind, class V>
inline MaskOf<V> apart_along(const Corners<V>& x, V Vector3<V>::*component) {
  constexpr int cut = first_of<kind>;
  const Range<V> a = range_of(x.start, component, 0, cut), b = range_of(x.start, component, cut, 4);
  const Range<V> c = range_of(x.end, component, 0, cut), d = range_of(x.end, component, cut, 4);
  return ((a.greatest < b.least) & (c.greatest < d.least)) | ((a.least > b.greatest) & (c.least > d.greatest));
}
template <Kind kind, class V>
inline MaskOf<V> apart_along_axes(const Corners<V>& x) {
  return apart_along<kind>(x, &Vector3<V>::x) | apart_along<kind>(x, &Vector3<V>::y) |
         apart_along<kind>(x, &Vector3<V>::z);
}

// --- Numbers of the pair's shape

// Vertices 1, 2, 3 from vertex 0, and the greatest magnitude of each component over the step.
template <class V>
struct Spans {
  Vector3<V> start[3], end[3], most[3];
};

template <class V>
inline Vector3<V> greater_of(const Vector3<V>& a, const Vector3<V>& b) {
  return {max(abs(a.x), abs(b.x)), max(abs(a.y), abs(b.y)), max(abs(a.z), abs(b.z))};
}
template <class V>
inline Spans<V> spans_of(const Corners<V>& x) {
  Spans<V> spans;
  for (int k = 0; k < 3; ++k) {
    spans.start[k] = x.start[k + 1] - x.start[0], spans.end[k] = x.end[k + 1] - x.end[0];
    spans.most[k] = greater_of(spans.start[k], spans.end[k]);
  }
  return spans;
}

// u of numbers of type V, and what underflow may cost: a product that underflows loses half of 2^-149 (double: of
// 2^-1074), and the terms below have fewer than 2^6 such losses, each times two spans at the most, of up to 2^21 m.
template <class V>
inline constexpr float unit = 0x1p-24f;
template <>
inline constexpr double unit<double> = 0x1p-53;
template <class V>
inline constexpr float least = 0x1p-100f;
template <>
inline constexpr double least<double> = 0x1p-1000;

// --- The plane: the vertices are never in one plane

// Six times the volume of the tetrahedron of the vertices: a cubic of time, given by b0, 3 b1, 3 b2, b3, where b are
// its coefficients in Bernstein's basis. The cubic lies between the least and the greatest b. `size` is the sum of the
// magnitudes of the six terms of the determinant, at most.
template <class V>
struct Cubic {
  V b0, b1_3, b2_3, b3, size;
};

template <class V>
inline Cubic<V> cubic_of(const Spans<V>& s) {
  const Vector3<V> n_start = cross(s.start[1], s.start[2]), n_end = cross(s.end[1], s.end[2]);
  const Vector3<V> n_mixed = cross(s.start[1], s.end[2]) + cross(s.end[1], s.start[2]);
  const Vector3<V>&a = s.most[0], &b = s.most[1], &c = s.most[2];
  const Vector3<V> n_most = {b.y * c.z + b.z * c.y, b.z * c.x + b.x * c.z, b.x * c.y + b.y * c.x};
  return {dot(s.start[0], n_start), dot(s.end[0], n_start) + dot(s.start[0], n_mixed),
          dot(s.start[0], n_end) + dot(s.end[0], n_mixed), dot(s.end[0], n_end), dot(a, n_most)};
}

// A term of b0 is rounded in three spans, two products and the sums of the cross product (1) and of the dot product
// (2): (5 + 3 k) u, where k is the roundings of a span. One of 3 b1 also in n_mixed and in the last sum, and there are
// three determinants: 3 (7 + 3 k) u. The size that is computed is too small by 8 u of itself at the most, and one
// rounding more comes with the factor: less than u of the size.
template <class V>
inline V rounding_of_end(const Cubic<V>& cubic, int span_roundings = 1) {
  return static_cast<float>(6 + 3 * span_roundings) * unit<V> * cubic.size + least<V>;
}
template <class V>
inline V rounding_of_middle(const Cubic<V>& cubic, int span_roundings = 1) {
  return static_cast<float>(22 + 9 * span_roundings) * unit<V> * cubic.size + least<V>;
}

template <class V>
inline MaskOf<V> never_in_plane(const Cubic<V>& c, int span_roundings = 1) {
  const V end = rounding_of_end(c, span_roundings), middle = rounding_of_middle(c, span_roundings);
  return ((c.b0 > end) & (c.b1_3 > middle) & (c.b2_3 > middle) & (c.b3 > end)) |
         ((c.b0 < -end) & (c.b1_3 < -middle) & (c.b2_3 < -middle) & (c.b3 < -end));
}

// --- Along any direction, which points from the second element to the first

// A term of a product with a span is rounded in a span, a product and two sums: (k + 3) u; of two such products and
// their difference: 2 (k + 3) u + 2 u. The bound's own roundings take less than 2 u more.
template <Kind kind, class V>
inline MaskOf<V> apart_along(const Spans<V>& spans, const Vector3<V>& direction, int span_roundings) {
  const Vector3<V> d = greater_of(direction, direction);
  const Vector3<V> most = greater_of(spans.most[0], greater_of(spans.most[1], spans.most[2]));
  const V rounding = static_cast<float>(10 + 2 * span_roundings) * unit<V> * dot(d, most) + least<V>;
  const auto gap = [&](const Vector3<V>(&x)[3]) {
    const V a = dot(direction, x[0]), b = dot(direction, x[1]), c = dot(direction, x[2]);
    const V zero = 0.f;  // of vertex 0
    return kind == Kind::point_triangle ? zero - max(a, max(b, c)) : min(zero, a) - max(b, c);
  };
  return (gap(spans.start) > rounding) & (gap(spans.end) > rounding);
}

}  // namespace lockstep::production_cloth::meeting
