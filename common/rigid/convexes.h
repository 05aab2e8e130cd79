// What the convexes of serial/ and openmp/ share: small formulas, for scalars and lanes, and limits. The contract is in
// common/rigid/narrow_phase.h.
#pragma once

#include <limits>

#include "common/math.h"
#include "common/rigid/gjk_cores.h"
#include "common/rigid/world.h"

namespace lockstep::rigid {

// Of a hull of 64 vertices (Euler): faces and edges, if all faces are triangles; a face may have all its vertices.
inline constexpr int most_hull_faces = 2 * most_hull_vertices - 4;
inline constexpr int most_hull_edges = 3 * most_hull_vertices - 6;
// Of sixty-four: each edge of the incident face gives two candidates, each corner of the reference one, and the closest points one.
inline constexpr int most_candidates = 3 * most_hull_vertices + 1;

// Edges whose directions differ by less than 2^-20 (the sine) have no axis but rounding; this is the square.
inline constexpr float parallel_2 = 0x1p-40f;
// Nearer than 2^-13 of the pair's reach, 1e-4, the line between the closest points is too short to tell its direction: rounding, some
// epsilon of the reach, would turn it by more than a milliradian.
inline constexpr float touching = 0x1p-13f;
// Of a face and the normal: the face counts as perpendicular to it within 3.6 degrees.
inline constexpr float least_cosine = .998f;
// Of two faces as good within 1e-3 (of the cosine), a's is clipped against, so that which one it is does not hang on rounding.
inline constexpr float preference = 1e-3f;
// A reference corner is dropped on the other face if this is not as steep as 84 degrees.
inline constexpr float least_incident_cosine = .1f;

template <class T>
inline T taxicab(const Vector3<T>& v) {
  return abs(v.x) + abs(v.y) + abs(v.z);
}

template <class T>
inline Vector3<T> absolute(const Vector3<T>& v) {
  return {abs(v.x), abs(v.y), abs(v.z)};
}

// No coordinate in a's frame is larger: what rounding is relative to.
template <class T>
inline T reach_of(const Cores<T>& cores, const Vector3<T>& centre_a, const Vector3<T>& half_a, const Vector3<T>& centre_b,
                  const Vector3<T>& half_b) {
  return dot(cores.scale_a, absolute(centre_a) + half_a) + dot(cores.scale_b, absolute(centre_b) + half_b) + taxicab(cores.offset);
}

// Of the corners that the point nearest to the origin lies between, as GJK leaves them: their weights, and that point. Corners are those of
// the difference; beyond the count they are anything finite.
template <class T>
struct Nearest {
  T weight[4];
  Vector3<T> point;
};
template <class T, class Truth>
inline Nearest<T> nearest_between(Truth two, Truth three, Truth four, const Vector3<T>* corner) {
  const T none(0), one(1);
  const Vector3<T>& p = corner[0];
  const Vector3<T> e = corner[1] - p, f = corner[2] - p, g = corner[3] - p;
  const Vector3<T> p_e = cross(p, e), e_f = cross(e, f), e_g = cross(e, g), f_g = cross(f, g);
  const T per_length_2 = one / dot(e, e), per_area_2 = one / dot(e_f, e_f), per_volume = one / dot(e, f_g);
  const T s = select(two, min(-dot(p, e) * per_length_2, one),
                     select(three, -dot(e_f, cross(p, f)) * per_area_2, select(four, -dot(p, f_g) * per_volume, none)));
  const T t = select(three, dot(e_f, p_e) * per_area_2, select(four, dot(p, e_g) * per_volume, none));
  const T u = select(four, -dot(p, e_f) * per_volume, none);

  // Off an edge or a face along a vector at right angles to it, and not what is left of p: so its direction is good however short it is.
  const Vector3<T> off_edge = cross(e, p_e);
  const T along = dot(p, e_f) * per_area_2;
  const auto choose = [&](T at_corner, T of_edge, T of_face) {
    return select(four, none, select(three, along * of_face, select(two, per_length_2 * of_edge, at_corner)));
  };
  return {{one - (s + t + u), s, t, u}, {choose(p.x, off_edge.x, e_f.x), choose(p.y, off_edge.y, e_f.y), choose(p.z, off_edge.z, e_f.z)}};
}

// Coordinates carry a rounding of some epsilon / 2 of the reach: the turned and moved vertices of b seven operations', a product with a
// unit vector three more. Separations that differ by less may be equal.
template <class Real>
inline constexpr Real slack_per_reach = 4 * std::numeric_limits<Real>::epsilon();

// Points nearer than this many slacks are one.
inline constexpr float apart_slacks = 16;

// Where a point of a contact comes from: entry (even) and exit (odd) of the edges of the incident face, corners of the reference face, or
// the closest points; and of which faces, reference and incident.
inline constexpr int slot_of_corner = 2 * most_hull_vertices, slot_of_closest = slot_of_corner + most_hull_vertices;
template <class I, class J>
inline auto feature_of(I of_b, I reference, I incident, J slot) {
  return ((of_b * I(128) + reference) * I(128) + incident) * I(256) + I(slot);
}

}  // namespace lockstep::rigid
