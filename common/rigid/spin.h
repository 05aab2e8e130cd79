// How a free body turns, for T a scalar or sixteen lanes.
//
// Without a torque the angular momentum L stays, and the angular velocity w = I^-1 L changes as the axes of inertia turn: that is the
// gyroscopic term w x I w. A step turns the body by the w of its middle (the midpoint rule, of second order) and takes w anew from the same
// L, so that L is kept to within rounding, whatever the step.
#pragma once

#include "common/rigid/rotation.h"

namespace lockstep::rigid {

// The orientation after turning by `angle`, rad, along the world's axes: q + angle q / 2 brought back to length 1. Of second order: the
// angle turned by is 2 atan(|angle| / 2).
template <class T>
inline Quaternion<T> turned_by(const Vector3<T>& angle, const Quaternion<T>& q) {
  const Vector3<T> half = T(.5f) * angle;
  const Quaternion<T> step = Quaternion<T>{half.x, half.y, half.z, T(0)} * q;
  const Quaternion<T> sum = {q.x + step.x, q.y + step.y, q.z + step.z, q.w + step.w};
  const T length = T(1) / sqrt(sum.x * sum.x + sum.y * sum.y + sum.z * sum.z + sum.w * sum.w);
  return {sum.x * length, sum.y * length, sum.z * length, sum.w * length};
}

// Of a body with principal inverse inertia `inverse`, > 0: I^-1 L and I w.
template <class T>
inline Vector3<T> velocity_of_momentum(const Quaternion<T>& q, const Vector3<T>& inverse, const Vector3<T>& momentum) {
  const Matrix3<T> r = matrix_of(q);
  const Vector3<T> local = transposed_times(r, momentum);
  return r * Vector3<T>{inverse.x * local.x, inverse.y * local.y, inverse.z * local.z};
}
template <class T>
inline Vector3<T> momentum_of_velocity(const Quaternion<T>& q, const Vector3<T>& inverse, const Vector3<T>& velocity) {
  const Matrix3<T> r = matrix_of(q);
  const Vector3<T> local = transposed_times(r, velocity);
  return r * Vector3<T>{local.x / inverse.x, local.y / inverse.y, local.z / inverse.z};
}

// The w of which momentum_of_velocity makes L again: I^-1 L with one step of iterative refinement. A quaternion's length is off by a
// rounding, and its matrix is no exact rotation; I^-1 L alone would make another L by as much (3.4 u a step), and as a free body turns by
// about the same angle in each step, the rounding is the same in each, too, and adds up.
template <class T>
inline Vector3<T> velocity_keeping_momentum(const Quaternion<T>& q, const Vector3<T>& inverse, const Vector3<T>& momentum) {
  const Vector3<T> velocity = velocity_of_momentum(q, inverse, momentum);
  return velocity + velocity_of_momentum(q, inverse, momentum - momentum_of_velocity(q, inverse, velocity));
}

}  // namespace lockstep::rigid
