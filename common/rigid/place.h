// The pose of a collider in the world, and the box around it. For T a scalar or floatv, in the same order of
// operations.
#pragma once

#include "common/rigid/world.h"
#include "common/spatial/bounds.h"

namespace lockstep::rigid {

template <class T>
inline Pose<T> in_world(const Pose<T>& body, const Pose<T>& local) {
  return {body.position + matrix_of(body.orientation) * local.position, body.orientation * local.orientation, T(0)};
}

// The box around a turned box. Its extent along a world axis is the sum of the half sides, each times the absolute
// value of its component along that axis. `centre` and `half` are those of the hull's own box before `scale`, m;
// `widening` is the radius plus the margin, m.
template <class T>
inline spatial::Box<T> box_around(const Pose<T>& pose, const Quad<T>& scale, const Quad<T>& centre, const Quad<T>& half,
                                  const T& widening) {
  const Matrix3<T> m = matrix_of(pose.orientation);
  const Vector3<T> middle = pose.position + m * Vector3<T>{scale.x * centre.x, scale.y * centre.y, scale.z * centre.z};
  const Matrix3<T> reach = {
      {abs(m.x.x), abs(m.x.y), abs(m.x.z)}, {abs(m.y.x), abs(m.y.y), abs(m.y.z)}, {abs(m.z.x), abs(m.z.y), abs(m.z.z)}};
  const Vector3<T> extent = reach * Vector3<T>{scale.x * half.x, scale.y * half.y, scale.z * half.z} +
                            Vector3<T>{widening, widening, widening};
  return {middle - extent, middle + extent};
}

// Extends `box` to a turned vertex of a hull.
template <class T>
inline void reach_to(spatial::Box<T>& box, const Matrix3<T>& m, const Vector3<T>& scale, const Vector3<T>& vertex) {
  const Vector3<T> v = m * Vector3<T>{scale.x * vertex.x, scale.y * vertex.y, scale.z * vertex.z};
  box = around(box, {v, v});
}

// A box around turned vertices, moved to the position and widened.
template <class T>
inline spatial::Box<T> moved(const spatial::Box<T>& box, const Vector3<T>& position, const T& widening) {
  const Vector3<T> wide = {widening, widening, widening};
  return {position + (box.low - wide), position + (box.high + wide)};
}

}  // namespace lockstep::rigid
