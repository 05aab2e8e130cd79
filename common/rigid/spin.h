// How a free body moves in a step, for T a scalar or sixteen lanes.
//
// Without a torque the angular momentum L is constant. The angular velocity w = I^-1 L changes as the axes of inertia
// turn: the gyroscopic term w x I w. A step turns the body by the w of its middle (midpoint rule, second order) and
// computes w anew from the same L. So L is kept to within rounding for any step.
#pragma once

#include "common/rigid/world.h"

namespace lockstep::rigid {

// The orientation after turning by `angle`, rad, along the world's axes: q + angle q / 2, normalised. Second order: the
// angle turned by is 2 atan(|angle| / 2).
template <class T>
inline Quaternion<T> turned_by(const Vector3<T>& angle, const Quaternion<T>& q) {
  const Vector3<T> half = T(.5f) * angle;
  const Quaternion<T> step = Quaternion<T>{half.x, half.y, half.z, T(0)} * q;
  const Quaternion<T> sum = {q.x + step.x, q.y + step.y, q.z + step.z, q.w + step.w};
  const T length = T(1) / sqrt(sum.x * sum.x + sum.y * sum.y + sum.z * sum.z + sum.w * sum.w);
  return {sum.x * length, sum.y * length, sum.z * length, sum.w * length};
}

// I^-1 L and I w of a body with principal inverse inertia `inverse`, > 0.
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

// The w whose momentum_of_velocity is L: I^-1 L with one step of iterative refinement. A quaternion's length is off by
// a rounding, so its matrix is no exact rotation. I^-1 L alone would change L by as much (3.4 u a step). A free body
// turns by about the same angle in each step. Then the rounding is the same in each step, too, and adds up.
template <class T>
inline Vector3<T> velocity_keeping_momentum(const Quaternion<T>& q, const Vector3<T>& inverse,
                                            const Vector3<T>& momentum) {
  const Vector3<T> velocity = velocity_of_momentum(q, inverse, momentum);
  return velocity + velocity_of_momentum(q, inverse, momentum - momentum_of_velocity(q, inverse, velocity));
}

// Moves a body by dt with the velocities `mean`. Gives `motion` the angular velocity that keeps its own angular
// momentum.
template <class T>
inline void advance(const Quad<T>& inverse_mass, const Motion<T>& mean, const T& dt, Pose<T>& pose, Motion<T>& motion) {
  const Vector3<T> inverse = vector_of(inverse_mass);
  pose.position = pose.position + dt * mean.velocity;
  const Vector3<T> kept = momentum_of_velocity(pose.orientation, inverse, motion.angular_velocity);
  const Vector3<T> turning = momentum_of_velocity(pose.orientation, inverse, mean.angular_velocity);
  const Quaternion<T> middle = turned_by(T(.5f) * dt * mean.angular_velocity, pose.orientation);
  pose.orientation = turned_by(dt * velocity_of_momentum(middle, inverse, turning), pose.orientation);
  motion.angular_velocity = velocity_keeping_momentum(pose.orientation, inverse, kept);
}

}  // namespace lockstep::rigid
