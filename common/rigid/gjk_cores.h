// Two convex cores, seen from the first: hulls as they stand in the library, and how to get from there to a's frame.
// For scalars and lanes.
//
// Vertices are not turned one by one. A direction is brought into each hull's own frame, where the support mapping
// finds the farthest vertex, and that one vertex is brought into a's.
#pragma once

#include "common/rigid/world.h"

namespace lockstep::rigid {

template <class T>
struct Cores {
  Vector3<T> scale_a, scale_b;
  Matrix3<T> turn;      // from b's frame to a's
  Vector3<T> offset;    // of b's origin from a's, in a's frame
  Matrix3<T> from_a;    // from a's frame to the world
  Vector3<T> origin_a;  // in the world
};

template <class T>
inline Vector3<T> scaled(const Vector3<T>& scale, const Vector3<T>& v) {
  return {scale.x * v.x, scale.y * v.y, scale.z * v.z};
}

template <class T>
inline Cores<T> make_cores(const Vector3<T>& scale_a, const Vector3<T>& scale_b, const Vector3<T>& position_a,
                           const Vector3<T>& position_b, const Quaternion<T>& orientation_a,
                           const Quaternion<T>& orientation_b) {
  const Matrix3<T> from_a = matrix_of(orientation_a);
  return {scale_a,
          scale_b,
          matrix_of(conjugate(orientation_a) * orientation_b),
          transposed_times(from_a, position_b - position_a),
          from_a,
          position_a};
}

// A direction in a's frame, along which the vertices of each hull are to be compared.
template <class T>
inline Vector3<T> direction_in_a(const Cores<T>& cores, const Vector3<T>& direction) {
  return scaled(cores.scale_a, direction);
}
template <class T>
inline Vector3<T> direction_in_b(const Cores<T>& cores, const Vector3<T>& direction) {
  return scaled(cores.scale_b, transposed_times(cores.turn, direction));
}

// A vertex of each hull, in a's frame.
template <class T>
inline Vector3<T> vertex_of_a(const Cores<T>& cores, const Vector3<T>& vertex) {
  return scaled(cores.scale_a, vertex);
}
template <class T>
inline Vector3<T> vertex_of_b(const Cores<T>& cores, const Vector3<T>& vertex) {
  return cores.turn * scaled(cores.scale_b, vertex) + cores.offset;
}

template <class T>
inline Vector3<T> in_world(const Cores<T>& cores, const Vector3<T>& point) {
  return cores.origin_a + cores.from_a * point;
}

}  // namespace lockstep::rigid
