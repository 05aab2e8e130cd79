// Limits, tolerances and small formulas that convex_axes and convex_clip share, for T a number or sixteen lanes.
#pragma once

#include <limits>

#include "common/math.h"
#include "common/rigid/gjk_cores.h"
#include "common/rigid/world.h"

namespace lockstep::rigid {

// Of a hull of 64 vertices (Euler): faces and edges, if all faces are triangles.
inline constexpr int most_hull_faces = 2 * most_hull_vertices - 4;
inline constexpr int most_hull_edges = 3 * most_hull_vertices - 6;

// Coordinates carry rounding errors, epsilon / 2 of the pair's reach for each operation: seven in the turned and moved
// vertices of b, three more in a product with a unit vector. Separations that differ by less than this slack may be
// equal.
template <class Real>
inline constexpr Real slack_per_reach = 4 * std::numeric_limits<Real>::epsilon();

// Points nearer than this many slacks are one.
inline constexpr float apart_slacks = 16;

// A face counts as perpendicular to the normal within 3.6 degrees.
inline constexpr float least_cosine = .998f;

template <class T>
inline T taxicab(const Vector3<T>& v) {
  return abs(v.x) + abs(v.y) + abs(v.z);
}

template <class T>
inline Vector3<T> absolute(const Vector3<T>& v) {
  return {abs(v.x), abs(v.y), abs(v.z)};
}

// The pair's reach: no coordinate in a's frame is larger. Rounding is relative to it. `centre` and `half` are those of
// the hulls' boxes.
template <class T>
inline T reach_of(const Cores<T>& cores, const Quad<T>& centre_a, const Quad<T>& half_a, const Quad<T>& centre_b,
                  const Quad<T>& half_b) {
  return dot(cores.scale_a, absolute(vector_of(centre_a)) + vector_of(half_a)) +
         dot(cores.scale_b, absolute(vector_of(centre_b)) + vector_of(half_b)) + taxicab(cores.offset);
}

}  // namespace lockstep::rigid
