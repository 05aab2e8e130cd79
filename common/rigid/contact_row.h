// What projected Gauss-Seidel does to one row of a contact, for T a scalar or sixteen lanes.
#pragma once

#include <algorithm>

#include "common/math.h"
#include "common/rigid/contact_constraint.h"
#include "common/rigid/contact_solver.h"

namespace lockstep::rigid {

template <class T>
struct Velocity {
  Vector3<T> linear, angular;  // m/s, rad/s
};

// Of b's point relative to a's.
template <class T>
inline Vector3<T> relative_velocity(const Velocity<T>& a, const Velocity<T>& b, const ConstraintPoint<T>& p) {
  return (b.linear + cross(b.angular, p.arm_b)) - (a.linear + cross(a.angular, p.arm_a));
}

// An impulse at a point: on b, and the other way on a.
template <class T>
inline void apply(const ContactConstraint<T>& c, const ConstraintPoint<T>& p, const Vector3<T>& impulse, Velocity<T>& a, Velocity<T>& b) {
  a.linear = a.linear - c.a.mass * impulse;
  a.angular = a.angular - c.a.inertia * cross(p.arm_a, impulse);
  b.linear = b.linear + c.b.mass * impulse;
  b.angular = b.angular + c.b.inertia * cross(p.arm_b, impulse);
}

// The mass that two bodies set against a unit impulse at a point along a direction: 1 / (J M^-1 J^T).
template <class T>
inline T effective_mass(const ContactConstraint<T>& c, const ConstraintPoint<T>& p, const Vector3<T>& direction) {
  const Vector3<T> turn_a = cross(p.arm_a, direction), turn_b = cross(p.arm_b, direction);
  return T(1) / (c.a.mass + c.b.mass + dot(turn_a, c.a.inertia * turn_a) + dot(turn_b, c.b.inertia * turn_b));
}

// Friction along a tangent: whatever stops the sliding, up to what the normal impulse allows. Returns the change of the impulse.
template <class T>
inline T friction_step(const Row<T>& row, const T& sliding, const T& most) {
  return min(max(row.impulse - row.mass * sliding, -most), most) - row.impulse;
}

// How a contact answers: with all of what stops the approach (mass 1, impulse 0), or, where it is to push bodies apart, as a spring with a
// damper whose answer over a step is found implicitly: softer in what it asks, and giving way a little to what it has pushed already.
template <class T>
struct Softness {
  T rate;  // 1/s: of a depth, asked back a second
  T mass, impulse;
};
template <class T>
inline Softness<T> rigid_contact() {
  return {T(0), T(1), T(0)};
}
// A harmonic oscillator of a frequency, Hz, and a damping ratio, over a step h: Catto, Soft Constraints (GDC 2011).
inline Softness<double> soft_contact(double hertz, double damping, double h) {
  const double omega = 6.283185307179586 * hertz, a = 2 * damping + h * omega, b = h * omega * a;
  return {omega / a, b / (1 + b), 1 / (1 + b)};
}

// Non-penetration: whatever stops an approach that goes beyond the surface, but never a pull; where s < 0, softly. Returns the change of
// the impulse.
template <class T>
inline T normal_step(const Row<T>& row, const T& parting, const T& separation, const T& per_step, const Softness<T>& soft,
                     const T& most_push) {
  const auto apart = separation > T(0);
  const T target = select(apart, separation * per_step, max(soft.rate * separation, -most_push));
  const T mass = select(apart, T(1), soft.mass), give = select(apart, T(0), soft.impulse);
  return max(row.impulse - mass * row.mass * (parting + target) - give * row.impulse, T(0)) - row.impulse;
}

// Restitution: whatever makes the points part at least with `bounce`. Returns the change of the impulse.
template <class T>
inline T bounce_step(const Row<T>& row, const T& parting, const T& bounce) {
  return max(row.impulse - row.mass * (parting - bounce), T(0)) - row.impulse;
}

// Two unit vectors that make a right-handed frame with a unit normal: tangent x bitangent = normal. Duff et al., Building an Orthonormal
// Basis, Revisited, JCGT 6 (2017), with axes renamed so that it is smooth but where the normal crosses y = 0, on vertical walls: y is up.
template <class T>
inline void make_tangents(const Vector3<T>& n, Vector3<T>& tangent, Vector3<T>& bitangent) {
  const T sign = select(n.y < T(0), T(-1), T(1)), a = T(-1) / (sign + n.y), b = n.z * n.x * a;
  tangent = {sign * b, -sign * n.z, T(1) + sign * n.z * n.z * a};
  bitangent = {sign + n.x * n.x * a, -n.x, b};
}

// A body's velocities as a substep begins: gravity's share is added, and what all impulses of the substep before added is added once more.
// That is the warm start: the same impulses, without a visit to the contacts. `before` are the velocities that the substep's impulses come
// on top of.
template <class Real>
inline void begin_substep(const Vector3<Real>& gained, Motion<Real>& before, Motion<Real>& motion) {
  const Vector3<Real> pushed = motion.velocity - before.velocity, turned = motion.angular_velocity - before.angular_velocity;
  before.velocity = motion.velocity + gained;
  before.angular_velocity = motion.angular_velocity;
  motion.velocity = before.velocity + pushed;
  motion.angular_velocity = before.angular_velocity + turned;
}

// What the sweeps of a substep are given.
template <class Real>
struct Sweep {
  Real per_step;  // 1 / h
  Softness<Real> soft;
  Real most_push;
};
template <class Real>
struct Substep {
  Real h;
  Sweep<Real> pushing, resting;
  Vector3<Real> gained;  // velocity by gravity
};
template <class Real>
inline Substep<Real> substep_of(const SolverSettings& settings) {
  const double h = settings.time_step / settings.substeps;
  const auto [rate, mass, impulse] = soft_contact(std::min(settings.hertz, .25 / h), settings.damping, h);
  const auto real = [](double x) { return static_cast<Real>(x); };
  const Real per_step = real(1 / h), most_push = real(settings.most_push);
  const Vector3<double> gained = h * settings.gravity;
  return {real(h),
          {per_step, {real(rate), real(mass), real(impulse)}, most_push},
          {per_step, rigid_contact<Real>(), most_push},
          {real(gained.x), real(gained.y), real(gained.z)}};
}

}  // namespace lockstep::rigid
