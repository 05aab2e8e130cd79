// What GJK does to a simplex, in formulas for scalars and lanes alike: which point of an edge, a face or a tetrahedron
// is nearest to the origin. `newest` is the corner that came last; edges e, f, g lead from it to the corners before.
#pragma once

#include <type_traits>

#include "common/math.h"
#include "common/rigid/truth.h"
#include "common/vector3.h"

namespace lockstep::rigid {

template <class T>
inline constexpr float few_epsilon = std::is_same_v<T, double> ? 0x1p-50f : 0x1p-21f;

// An edge, and what its formulas share.
template <class T>
struct Edge {
  Vector3<T> along;
  T length_2, per_length_2;
  Vector3<T> newest_along;  // newest x along
};

template <class T>
inline Edge<T> make_edge(const Vector3<T>& newest, const Vector3<T>& corner) {
  const Vector3<T> along = corner - newest;
  const T length_2 = dot(along, along);
  return {along, length_2, T(1) / length_2, cross(newest, along)};
}

// The point newest + s e + t f. Where `inside` holds, s, t >= 0 and s + t <= 1 within rounding, so that the point is
// one of the simplex; where not, nothing else holds, either.
template <class T>
struct Candidate {
  Truth<T> inside;
  T s, t;
  T distance_2;  // of the point from the origin
  // Towards the point or away from it, of any length: at right angles to the edges but for its own rounding, however
  // little is left of the point itself when s e and t f have been taken from newest.
  Vector3<T> normal;
};

// Of the edge. Outside where a corner alone is nearest, and where squares of so short an edge vanish.
template <class T>
inline Candidate<T> nearest_on_edge(const Vector3<T>& newest, const Edge<T>& e) {
  const T down = -dot(newest, e.along);
  const Truth<T> inside = (down > T(0)) & (down < e.length_2) & (e.length_2 > T(1e-37f));
  return {inside, down * e.per_length_2, T(0), dot(e.newest_along, e.newest_along) * e.per_length_2,
          e.per_length_2 * cross(e.along, e.newest_along)};
}

// Of the face between e and f. Outside where an edge is nearer, and where the face has no area. Where e and f are
// nearly one line, rounding moves the point along it, far compared with the width of the face; so it is brought back to
// where it is nearest along f. The weight of the newest corner may be as small as rounding: the step is then almost
// zero, but the next iteration may need its corner.
template <class T>
inline Candidate<T> nearest_on_face(const Vector3<T>& newest, const Edge<T>& e, const Edge<T>& f) {
  const Vector3<T> normal = cross(e.along, f.along);
  const T area_2 = dot(normal, normal), along_e = -dot(normal, f.newest_along), along_f = dot(normal, e.newest_along);
  const T per_area = T(1) / area_2, s = along_e * per_area, t_about = along_f * per_area;
  const Vector3<T> about = newest + s * e.along + t_about * f.along;
  const T back = dot(about, f.along) * f.per_length_2, t = t_about - back;
  const Vector3<T> point = about - back * f.along;
  const Truth<T> inside = (area_2 > T(0)) & (s > T(0)) & (t > T(0)) & (s + t < T(1 + few_epsilon<T>));
  return {inside, s, t, dot(point, point), normal};
}

// Where the origin is in a tetrahedron: newest + r e + s f + t g.
template <class T>
struct Enclosure {
  Truth<T> inside;
  T r, s, t;
};

// From the normals e x f, e x g and f x g. Inside only where it is by the signs of all four weights: a flat one
// encloses nothing.
template <class T>
inline Enclosure<T> enclosure(const Vector3<T>& newest, const Vector3<T>& e, const Vector3<T>& ef, const Vector3<T>& eg,
                              const Vector3<T>& fg) {
  const T per_volume = T(1) / dot(e, fg);
  const T r = -dot(newest, fg) * per_volume, s = dot(newest, eg) * per_volume, t = -dot(newest, ef) * per_volume;
  const Truth<T> inside = (r > T(0)) & (s > T(0)) & (t > T(0)) & (r + s + t < T(1));
  return {inside, r, s, t};
}

}  // namespace lockstep::rigid
