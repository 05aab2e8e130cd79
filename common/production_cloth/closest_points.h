// The points of two elements of a cloth that are closest to each other: of a vertex and a triangle, or of two edges.
// For numbers and for lanes, in the same order of operations.
//
// Points are told by weights of the four vertices, signed as contacts have them (contacts.h). All is computed from
// differences of positions, so that the rounding of what is far from the origin does not count.
//
// Source: Ericson, Real-Time Collision Detection (2005), 5.1.5 and 5.1.9.
#pragma once

#include "common/math.h"
#include "common/vector3.h"

namespace lockstep::production_cloth {

template <class V>
struct Closest {
  V weight[4];
  Vector3<V> difference;  // m: from the triangle to the vertex, or from the second edge to the first
  V square;               // m^2: of its length
};

template <class V>
inline V within_0_1(const V& x) {
  return min(max(x, V(0)), V(1));
}

// numerator / denominator, or 0 where the denominator is not positive.
template <class V>
inline V share_of(const V& numerator, const V& denominator) {
  const auto is_there = denominator > V(0);
  return select(is_there, numerator / select(is_there, denominator, V(1)), V(0));
}

template <class V>
inline void keep_closer(const Closest<V>& other, Closest<V>& closest) {
  const auto closer = other.square < closest.square;
  for (int i = 0; i < 4; ++i) closest.weight[i] = select(closer, other.weight[i], closest.weight[i]);
  closest.difference = select(closer, other.difference, closest.difference);
  closest.square = select(closer, other.square, closest.square);
}

// The vertex x[0] and the triangle x[1], x[2], x[3]: the closest point of each side, and that inside where it is.
template <class V>
inline Closest<V> closest_of_point_triangle(const Vector3<V> (&x)[4]) {
  const Vector3<V> p = x[0] - x[1], side[2] = {x[2] - x[1], x[3] - x[1]};
  const V zero(0), one(1);
  // `u` of the second corner and `v` of the third.
  const auto at = [&](const V& u, const V& v) {
    const Vector3<V> d = p - (u * side[0] + v * side[1]);
    return Closest<V>{{one, -((one - u) - v), -u, -v}, d, dot(d, d)};
  };
  const V aa = dot(side[0], side[0]), ab = dot(side[0], side[1]), bb = dot(side[1], side[1]);
  const V pa = dot(p, side[0]), pb = dot(p, side[1]);
  const Vector3<V> opposite = side[1] - side[0];
  const V third = within_0_1(share_of(dot(p - side[0], opposite), dot(opposite, opposite)));

  Closest<V> closest = at(within_0_1(share_of(pa, aa)), zero);
  keep_closer(at(zero, within_0_1(share_of(pb, bb))), closest);
  keep_closer(at(one - third, third), closest);
  const V determinant = aa * bb - ab * ab;
  const V u = share_of(bb * pa - ab * pb, determinant), v = share_of(aa * pb - ab * pa, determinant);
  Closest<V> inside = at(u, v);
  const auto is_inside = (determinant > zero) & (u > zero) & (v > zero) & (u + v < one);
  inside.square = select(is_inside, inside.square, closest.square);
  keep_closer(inside, closest);
  return closest;
}

// The edges x[0], x[1] and x[2], x[3]. Where they are nearly parallel, so that rounding would decide where they are
// closest, one end of the first is taken.
template <class V>
inline Closest<V> closest_of_edge_edge(const Vector3<V> (&x)[4]) {
  constexpr float parallel = 1e-6f;  // square of the sine of the angle between edges; sixteen units of rounding
  const Vector3<V> first = x[1] - x[0], second = x[3] - x[2], apart = x[0] - x[2];
  const V zero(0), one(1);
  const V aa = dot(first, first), ab = dot(first, second), bb = dot(second, second);
  const V a = dot(first, apart), b = dot(second, apart);
  const V determinant = aa * bb - ab * ab;
  V s = within_0_1(share_of(ab * b - a * bb, determinant));
  s = select(determinant > V(parallel) * (aa * bb), s, zero);
  const V t = share_of(ab * s + b, bb), t_within = within_0_1(t);
  const auto is_off = (t < zero) | (t > one);
  s = select(is_off, within_0_1(share_of(ab * t_within - a, aa)), s);
  const Vector3<V> d = (apart + s * first) - t_within * second;
  return {{one - s, s, -(one - t_within), -t_within}, d, dot(d, d)};
}

}  // namespace lockstep::production_cloth
