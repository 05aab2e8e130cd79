// Contract: contacts kept from step to step. Two colliders that hardly moved relative to each other keep the features
// of their contact, its normal and its points. Separations and positions are computed anew.
//
// The normal turns with a, and the points move with b. A point's separation is its height over a plane that is fixed to
// a: where a's surface was, across the normal, when the contact was found. So a corner of b over a face of a keeps its
// exact separation. Elsewhere, and where another corner has come nearer, the error is bounded:
//
// No point of b moves farther in the axes of a than e_b = |d| + 2 sin(t / 2) r: d is how b's origin moved there, t the
// angle by which b turned, and r how far b reaches from its origin. Likewise e_a, of a in the axes of b. The gap
// between the two changes by at most e = min(e_a, e_b). The separation s of a kept point changes by at most e, too, and
// by t |s| more where e is e_a, because the point is |s| away from a. So the separation of the deepest point is off by
// at most 2 e + t |s|. A pair is kept while e <= tolerance. e is counted from the pose in which the contact was found,
// so that errors do not add up. Pairs without points are kept, too: a new contact is found before it is nearer than the
// margin by more than e.
//
// Source: Box2D and Box3D keep contacts in this way (Catto, box2d.org), with a tolerance of 50 mm. The bound is derived
//         in notes/narrow_phase.md.
#pragma once

#include <cstdint>
#include <span>

#include "common/array.h"
#include "common/math.h"
#include "common/rigid/manifold.h"
#include "common/rigid/pairs.h"
#include "common/rigid/world.h"

namespace lockstep::rigid {

// The tolerance, as a share of the margin.
inline constexpr double kept_share = .05;

// The contact of a pair, and where the two were when it was found. Aligned to lanes' records: in float 40 words, five
// records of eight.
template <class Real>
struct alignas(8 * sizeof(Real)) KeptContact {
  Pose<Real> b_in_a;      // pose of b in the axes of a
  Vector3<Real> normal;   // in the axes of a
  std::int32_t count;     // points, 0 .. 4
  Real reach_a, reach_b;  // m, from the colliders' origins
  Real unused[2];
  ContactPoint<Real> point[most_points];  // position: on the surface of b, in the axes of b;
                                          //   separation: along the normal, from a's origin to a's surface, m
  std::int32_t feature[most_points];
  std::int32_t more_unused[4];
};
static_assert(sizeof(KeptContact<float>) == 160);

// From step to step: the pairs with hulls, in order. Other pairs cost no more than to refresh a contact.
template <class Real>
struct KeptContacts {
  Pairs pairs;
  Array<KeptContact<Real>> contact;  // [pair]
  Array<KeptContact<Real>> next;     // scratch
};

// --- Formulas. For T a scalar or floatv

// How far a collider reaches from its origin at most, m: to the farthest corner of the box around its hull.
template <class T>
inline T reach_of(const Quad<T>& size, const Quad<T>& centre, const Quad<T>& half) {
  const Vector3<T> corner = {size.x * (abs(centre.x) + half.x), size.y * (abs(centre.y) + half.y),
                             size.z * (abs(centre.z) + half.z)};
  return sqrt(dot(corner, corner)) + size.w;
}

// The poses of a pair, and what both formulas below need of them.
template <class T>
struct PairPoses {
  Vector3<T> a, b;  // origins
  Matrix3<T> axes_a, axes_b;
  Pose<T> b_in_a;
};
template <class T>
inline PairPoses<T> pair_poses(const Pose<T>& a, const Pose<T>& b) {
  const Matrix3<T> axes_a = matrix_of(a.orientation);
  return {a.position,
          b.position,
          axes_a,
          matrix_of(b.orientation),
          {transposed_times(axes_a, b.position - a.position), conjugate(a.orientation) * b.orientation, T(0)}};
}

// e of the contract, m. NaN where a pose has become NaN.
template <class T>
inline T moved_since(const Pose<T>& then, const Pose<T>& now, const T& reach_a, const T& reach_b) {
  const auto [x, y, z, w] = conjugate(then.orientation) * now.orientation;
  const T chord = T(2) * sqrt(x * x + y * y + z * z);  // 2 sin(t / 2)
  const Vector3<T> b = now.position - then.position, a = transposed_times(matrix_of(now.orientation), now.position) -
                                                         transposed_times(matrix_of(then.orientation), then.position);
  return min(sqrt(dot(b, b)) + chord * reach_b, sqrt(dot(a, a)) + chord * reach_a);
}

// A point as a KeptContact has it, from one in the world; and back. `normal` is in the world.
template <class T>
inline ContactPoint<T> kept_point(const PairPoses<T>& poses, const Vector3<T>& normal, const ContactPoint<T>& point) {
  const Vector3<T> on_b = point.position + T(.5f) * point.separation * normal;
  return {transposed_times(poses.axes_b, on_b - poses.b), dot(normal, on_b - poses.a) - point.separation};
}
template <class T>
inline ContactPoint<T> refreshed_point(const PairPoses<T>& poses, const Vector3<T>& normal,
                                       const ContactPoint<T>& kept) {
  const Vector3<T> on_b = poses.b + poses.axes_b * kept.position;
  const T separation = dot(normal, on_b - poses.a) - kept.separation;
  return {on_b - T(.5f) * separation * normal, separation};
}

// --- Loops over the pairs with hulls, in order

// In, out: of_last[pair], the number of the pair's contact among `last`, or -1; -1, too, where the pair has moved by
// more than the tolerance. Out, for the others: their manifolds, and their contacts in next.
template <class Real>
using RefreshContacts = void(const Placed<Real>& placed, std::span<const Pair> pairs,
                             std::span<const KeptContact<Real>> last, Real tolerance, std::span<std::int32_t> of_last,
                             std::span<Manifold<Real>> manifolds, std::span<KeptContact<Real>> next);

// Out: contacts[which[k]] of pairs[k] and manifolds[which[k]].
template <class Real>
using KeepContacts = void(const Placed<Real>& placed, std::span<const Pair> pairs, std::span<const std::int32_t> which,
                          std::span<const Manifold<Real>> manifolds, std::span<KeptContact<Real>> contacts);

namespace serial {
RefreshContacts<float> refresh_contacts;
RefreshContacts<double> refresh_contacts;
KeepContacts<float> keep_contacts;
KeepContacts<double> keep_contacts;
}  // namespace serial

namespace openmp {
RefreshContacts<float> refresh_contacts;
KeepContacts<float> keep_contacts;
}  // namespace openmp

}  // namespace lockstep::rigid
