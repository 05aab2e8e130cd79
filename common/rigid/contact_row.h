// Projected Gauss-Seidel on the rows of a contact. T is a number or sixteen lanes. The mask, a bool or a maskv, says
// which lanes have the point.
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
template <class T>
inline Velocity<T> velocity_of(const Motion<T>& motion) {
  return {motion.velocity, motion.angular_velocity};
}

// The velocity of b's point relative to a's.
template <class T>
inline Vector3<T> relative_velocity(const Velocity<T>& a, const Velocity<T>& b, const ConstraintPoint<T>& p) {
  return (b.linear + cross(b.angular, p.arm_b)) - (a.linear + cross(a.angular, p.arm_a));
}

// Applies an impulse at a point: on b, and the opposite one on a.
template <class T>
inline void apply(const ContactConstraint<T>& c, const ConstraintPoint<T>& p, const Vector3<T>& impulse, Velocity<T>& a,
                  Velocity<T>& b) {
  a.linear = a.linear - c.a.mass * impulse;
  a.angular = a.angular - c.a.inertia * cross(p.arm_a, impulse);
  b.linear = b.linear + c.b.mass * impulse;
  b.angular = b.angular + c.b.inertia * cross(p.arm_b, impulse);
}

// The same in the lanes of the mask alone.
template <class T, class Mask>
[[gnu::always_inline]] inline void apply_where(const Mask& mask, const ContactConstraint<T>& c,
                                               const ConstraintPoint<T>& p, const Vector3<T>& impulse, Velocity<T>& a,
                                               Velocity<T>& b) {
  if (all(mask)) return apply(c, p, impulse, a, b);
  const Velocity<T> old_a = a, old_b = b;
  apply(c, p, impulse, a, b);
  a = {select(mask, a.linear, old_a.linear), select(mask, a.angular, old_a.angular)};
  b = {select(mask, b.linear, old_b.linear), select(mask, b.angular, old_b.angular)};
}

// --- A contact's constraint, from its manifold and its two bodies

// What a constraint reads of a body.
template <class T>
struct ContactBody {
  Pose<T> pose;
  Velocity<T> velocity;
  Quad<T> inverse_mass;  // as in Bodies
  T friction, restitution;
};

template <class T>
inline InverseMass<T> inverse_mass_of(const ContactBody<T>& body) {
  const Quad<T>& inverse = body.inverse_mass;
  return {inverse.w, turned(matrix_of(body.pose.orientation), inverse.x, inverse.y, inverse.z)};
}

// Two unit vectors that make a right-handed frame with a unit normal: tangent x bitangent = normal. Duff et al.,
// Building an Orthonormal Basis, Revisited, JCGT 6 (2017), with axes renamed: y is up, so the one
// discontinuity, at y = 0, is at vertical walls.
template <class T>
inline void make_tangents(const Vector3<T>& n, Vector3<T>& tangent, Vector3<T>& bitangent) {
  const T sign = select(n.y < T(0), T(-1), T(1)), a = T(-1) / (sign + n.y), b = n.z * n.x * a;
  tangent = {sign * b, -sign * n.z, T(1) + sign * n.z * n.z * a};
  bitangent = {sign + n.x * n.x * a, -n.x, b};
}

// Makes all of a constraint but its points.
template <class T>
inline void make_constraint(const Vector3<T>& normal, const ContactBody<T>& a, const ContactBody<T>& b,
                            ContactConstraint<T>& c) {
  c.normal = normal;
  make_tangents(c.normal, c.tangent, c.bitangent);
  c.friction = sqrt(a.friction * b.friction);
  c.a = inverse_mass_of(a), c.b = inverse_mass_of(b);
}

// The effective mass of two bodies at a point along a direction: 1 / (J M^-1 J^T).
template <class T>
inline T effective_mass(const ContactConstraint<T>& c, const ConstraintPoint<T>& p, const Vector3<T>& direction) {
  const Vector3<T> turn_a = cross(p.arm_a, direction), turn_b = cross(p.arm_b, direction);
  return T(1) / (c.a.mass + c.b.mass + dot(turn_a, c.a.inertia * turn_a) + dot(turn_b, c.b.inertia * turn_b));
}

// Impulses of the last step at a point.
template <class T>
struct PointImpulse {
  T normal, tangent, bitangent;
};

// An approach slower than `bounce_from`, m/s, does not bounce.
template <class T>
inline void make_point(const ContactConstraint<T>& c, const ContactBody<T>& a, const ContactBody<T>& b,
                       const ContactPoint<T>& at, const PointImpulse<T>& impulse, const T& bounce_from,
                       ConstraintPoint<T>& p) {
  p.arm_a = at.position - a.pose.position;
  p.arm_b = at.position - b.pose.position;
  p.normal = {effective_mass(c, p, c.normal), impulse.normal};
  p.tangent = {effective_mass(c, p, c.tangent), impulse.tangent};
  p.bitangent = {effective_mass(c, p, c.bitangent), impulse.bitangent};
  p.separation = at.separation;
  p.max_normal_impulse = T(0);
  const T normal_velocity = dot(relative_velocity(a.velocity, b.velocity, p), c.normal);
  const T restitution = max(a.restitution, b.restitution);
  p.bounce = select(normal_velocity < -bounce_from, -restitution * normal_velocity, T(0));
}

// --- Rows

// How a contact answers a violation. A rigid contact (mass 1, impulse 0) removes it at once. A soft contact, which
// pushes bodies apart, is a damped spring integrated implicitly over a step. It asks for less, and yields to a share of
// the impulse that it has applied already.
template <class T>
struct Softness {
  T rate;  // 1/s: the share of a depth that is corrected a second
  T mass, impulse;
};
template <class T>
inline Softness<T> rigid_contact() {
  return {T(0), T(1), T(0)};
}
// A harmonic oscillator of a frequency, Hz, and a damping ratio, over a step h, s: Catto, Soft Constraints (GDC 2011).
inline Softness<double> soft_contact(double hertz, double damping, double h) {
  const double omega = 6.283185307179586 * hertz, a = 2 * damping + h * omega, b = h * omega * a;
  return {omega / a, b / (1 + b), 1 / (1 + b)};
}

// The damping ratio of soft contacts of a frequency, Hz, in substeps of h, s: the one asked for, or more where substeps
// are long. A soft contact asks back the share f = h rate = h w / (2 z + h w) of its depth in one substep, w = 2 pi
// hertz. z >= 13.4 h w keeps f <= 1 / 27.8 = .036, whatever h. Bodies at rest lie as deep: the depth does not depend on
// z (notes/contact_solver.md, "How few substeps").
inline double damping_ratio(double hertz, double asked, double h) {
  return std::max(asked, 13.4 * h * 6.283185307179586 * hertz);
}

// Parameters of a sweep over all normals.
template <class T>
struct Sweep {
  T per_step;  // 1 / h
  Softness<T> soft;
  T max_bias_velocity;  // m/s: the fastest that penetrating bodies are pushed apart
};

// Friction along a tangent: the impulse that stops the sliding, within the friction cone's limit. Returns the change of
// the impulse.
template <class T>
inline T friction_step(const Row<T>& row, const T& tangent_velocity, const T& max_impulse) {
  return min(max(row.impulse - row.mass * tangent_velocity, -max_impulse), max_impulse) - row.impulse;
}

// Non-penetration: the impulse that stops an approach beyond the surface, but never pulls; softly where s < 0. Returns
// the change of the impulse.
template <class T>
inline T normal_step(const Row<T>& row, const T& normal_velocity, const T& separation, const Sweep<T>& sweep) {
  const auto apart = separation > T(0);
  const T bias = max(sweep.soft.rate * separation, -sweep.max_bias_velocity);
  const T target = select(apart, separation * sweep.per_step, bias);
  const T mass = select(apart, T(1), sweep.soft.mass), give = select(apart, T(0), sweep.soft.impulse);
  return max(row.impulse - mass * row.mass * (normal_velocity + target) - give * row.impulse, T(0)) - row.impulse;
}

// Restitution: the impulse after which the points part at least with `bounce`. Returns the change of the impulse.
template <class T>
inline T bounce_step(const Row<T>& row, const T& normal_velocity, const T& bounce) {
  return max(row.impulse - row.mass * (normal_velocity - bounce), T(0)) - row.impulse;
}

// --- Points: each changes its own impulses and the velocities of a and b

// Applies the impulses of the last step.
template <class T, class Mask>
[[gnu::always_inline]] inline void warm_start_point(const Mask& has_point, const ContactConstraint<T>& c,
                                                    const ConstraintPoint<T>& p, Velocity<T>& a, Velocity<T>& b) {
  const Vector3<T> impulse =
      p.normal.impulse * c.normal + p.tangent.impulse * c.tangent + p.bitangent.impulse * c.bitangent;
  apply_where(has_point, c, p, impulse, a, b);
}

// Friction along both tangents, limited by the normal impulse so far.
template <class T, class Mask>
[[gnu::always_inline]] inline void solve_friction(const Mask& has_point, const ContactConstraint<T>& c,
                                                  ConstraintPoint<T>& p, Velocity<T>& a, Velocity<T>& b) {
  const T max_impulse = c.friction * p.normal.impulse;
  const auto solve = [&](Row<T>& row, const Vector3<T>& direction) {
    const T change = friction_step(row, dot(relative_velocity(a, b, p), direction), max_impulse);
    row.impulse = row.impulse + change;
    apply_where(has_point, c, p, change * direction, a, b);
  };
  solve(p.tangent, c.tangent);
  solve(p.bitangent, c.bitangent);
}

// Non-penetration. `moved_a` and `moved_b` are how far the bodies have moved since the step began, m and rad.
template <class T, class Mask>
[[gnu::always_inline]] inline void solve_normal(const Mask& has_point, const ContactConstraint<T>& c,
                                                ConstraintPoint<T>& p, const Sweep<T>& sweep,
                                                const Velocity<T>& moved_a, const Velocity<T>& moved_b, Velocity<T>& a,
                                                Velocity<T>& b) {
  const T separation = p.separation + dot(relative_velocity(moved_a, moved_b, p), c.normal);
  const T normal_velocity = dot(relative_velocity(a, b, p), c.normal);
  const T change = normal_step(p.normal, normal_velocity, separation, sweep);
  p.normal.impulse = p.normal.impulse + change;
  p.max_normal_impulse = max(p.max_normal_impulse, p.normal.impulse);
  apply_where(has_point, c, p, change * c.normal, a, b);
}

// Whether a point bounces: its approach was fast, and it was hit.
template <class T>
inline auto has_bounce(const ConstraintPoint<T>& p) {
  return (p.bounce > T(0)) & (p.max_normal_impulse > T(0));
}
// Does not store the impulse of a bounce, because the next step must not start with it.
template <class T, class Mask>
[[gnu::always_inline]] inline void solve_bounce(const Mask& bounces, const ContactConstraint<T>& c,
                                                const ConstraintPoint<T>& p, Velocity<T>& a, Velocity<T>& b) {
  const T change = bounce_step(p.normal, dot(relative_velocity(a, b, p), c.normal), p.bounce);
  apply_where(bounces, c, p, change * c.normal, a, b);
}

// --- Bodies

// Begins a substep for a body: adds the velocity by gravity, and once more the change of velocity by all impulses of
// the substep before. That is the warm start: the same impulses, without a visit to the contacts. `before` are the
// velocities without the substep's impulses.
template <class Real>
inline void begin_substep(const Vector3<Real>& gravity_dv, Motion<Real>& before, Motion<Real>& motion) {
  const Vector3<Real> dv = motion.velocity - before.velocity, dw = motion.angular_velocity - before.angular_velocity;
  before.velocity = motion.velocity + gravity_dv;
  before.angular_velocity = motion.angular_velocity;
  motion.velocity = before.velocity + dv;
  motion.angular_velocity = before.angular_velocity + dw;
}

// Adds to `moved` how far a body moves in a substep h: v h and w h.
template <class Real>
inline void move_on(Real h, const Motion<Real>& motion, Motion<Real>& moved) {
  moved.velocity = moved.velocity + h * motion.velocity;
  moved.angular_velocity = moved.angular_velocity + h * motion.angular_velocity;
}

// The mean velocities of a step in which a body has moved by `moved`.
template <class Real>
inline Motion<Real> mean_motion(Real per_step, const Motion<Real>& moved) {
  return {per_step * moved.velocity, per_step * moved.angular_velocity, {}};
}

template <class Real>
struct Substep {
  Real h;  // s
  Sweep<Real> biased, relax;
  Vector3<Real> gravity_dv;  // m/s
};
template <class Real>
inline Substep<Real> substep_of(const SolverSettings& settings) {
  const double h = settings.time_step / settings.substeps;
  const double hertz = std::min(settings.hertz, .25 / h), damping = damping_ratio(hertz, settings.damping, h);
  const auto [rate, mass, impulse] = soft_contact(hertz, damping, h);
  const auto real = [](double x) { return static_cast<Real>(x); };
  const Real per_step = real(1 / h), max_bias_velocity = real(settings.max_bias_velocity);
  const Vector3<double> gravity_dv = h * settings.gravity;
  return {real(h),
          {per_step, {real(rate), real(mass), real(impulse)}, max_bias_velocity},
          {per_step, rigid_contact<Real>(), max_bias_velocity},
          {real(gravity_dv.x), real(gravity_dv.y), real(gravity_dv.z)}};
}

}  // namespace lockstep::rigid
