// Particles pushed out of one solid body, with friction, written once: for numbers in serial/, for sixteen lanes in
// openmp/.
//
// A body says of a point how deep it is inside and which way is out (its penetration depth and contact normal); all
// else is the same for all bodies. Velocity is what a particle has moved in the last step, so moving it is all that
// collision has to do: pushing it out stops it, and taking back what it slid is friction.
#pragma once

#include "common/cloth/cloth.h"
#include "common/math.h"
#include "common/vector3.h"

namespace lockstep::cloth {

// The shortest way out of a body: how deep the point is, positive inside, and a direction of length 1.
template <class V>
struct WayOut {
  V depth;  // m
  Vector3<V> normal;
};

template <class V, class Real>
[[gnu::always_inline]] inline Vector3<V> spread(const Vector3<Real>& a) {  // to all lanes
  return {a.x, a.y, a.z};
}

template <class V, class Real>
[[gnu::always_inline]] inline WayOut<V> way_out(const Plane<Real>& plane, const Vector3<V>& point) {
  const Vector3<V> normal = spread<V>(plane.normal);
  return {plane.offset - dot(normal, point), normal};
}

template <class V, class Real>
[[gnu::always_inline]] inline WayOut<V> way_out(const Capsule<Real>& capsule, const Vector3<V>& point) {
  const Vector3<Real> axis = capsule.to - capsule.from;
  const Real length_2 = dot(axis, axis);
  const Real per_length_2 = length_2 > 0 ? 1 / length_2 : Real(0);
  // From the nearest point of the capsule's axis to the particle.
  const Vector3<V> from = point - spread<V>(capsule.from);
  const V along = min(max(dot(from, spread<V>(axis)) * per_length_2, V(0)), V(1));
  const Vector3<V> way = from - along * spread<V>(axis);
  const V d = sqrt(dot(way, way));
  // On the axis every way is as good; up is one.
  const V per_d = select(d > V(0), V(1) / d, V(0));
  return {capsule.radius - d, {way.x * per_d, select(d > V(0), way.y * per_d, V(1)), way.z * per_d}};
}

template <class V, class Real>
[[gnu::always_inline]] inline WayOut<V> way_out(const Box<Real>& box, const Vector3<V>& point) {
  const Vector3<V> from_centre = point - spread<V>(box.centre);
  const Vector3<V> u = spread<V>(box.axis[0]), v = spread<V>(box.axis[1]), w = spread<V>(box.axis[2]);
  const V along_u = dot(from_centre, u), along_v = dot(from_centre, v), along_w = dot(from_centre, w);
  // Inside, the nearest face is the way out; outside, one of the depths is negative, and so is the least.
  const V depth_u = box.half.x - abs(along_u), depth_v = box.half.y - abs(along_v), depth_w = box.half.z - abs(along_w);
  const V depth = min(depth_u, min(depth_v, depth_w));
  const auto sign = [](V along) { return select(along < V(0), V(-1), V(1)); };
  const Vector3<V> by_v_or_w = select(depth == depth_v, sign(along_v) * v, sign(along_w) * w);
  return {depth, select(depth == depth_u, sign(along_u) * u, by_v_or_w)};
}

// Pushes the active particles that are inside of the body out of it, and says which were inside. `start` is where they
// were when the step began. Mask is bool or maskv.
template <class Body, class Real, class V, class Mask>
[[gnu::always_inline]] inline Mask push_out(const Body& body, Real friction, const Vector3<V>& start, Mask active,
                                            Vector3<V>& position) {
  const auto [depth, normal] = way_out(body, position);
  const Mask inside = active & (depth > V(0));
  if (none(inside)) return inside;
  const Vector3<V> surface = position + depth * normal;
  const Vector3<V> moved = surface - start;
  const Vector3<V> slid = moved - dot(moved, normal) * normal;
  const V slid_length = sqrt(dot(slid, slid)), most = friction * depth;
  const V share = select(slid_length > most, most / slid_length, V(1));  // of `slid`, that friction takes back
  position = select(inside, surface - share * slid, position);
  return inside;
}

}  // namespace lockstep::cloth
