// The force of the air on a triangle and the Verlet update of a particle, written once: for numbers in serial/, for
// sixteen lanes in openmp/. The equations stand in common/cloth/verlet.h.
#pragma once

#include "common/cloth/cloth.h"
#include "common/math.h"
#include "common/vector3.h"

namespace lockstep::cloth {

// One particle, or sixteen: V is a number, or lanes.
template <class V>
struct Particle {
  Vector3<V> position;  // m
  Vector3<V> moved;     // m: position - previous position, the velocity times the time step
};

// The force, N, of the dynamic pressure on the triangle (a, b, c); 0 on a triangle without area.
template <class Real, class V>
[[gnu::always_inline]] inline Vector3<V> air_force(const Model<Real>& model, const Particle<V>& a, const Particle<V>& b,
                                                   const Particle<V>& c) {
  const Real per_corner_and_second = 1 / (3 * model.time_step), quarter_drag = model.drag / 4;
  const Vector3<V> wind = {model.wind.x, model.wind.y, model.wind.z};
  const Vector3<V> n = cross(b.position - a.position, c.position - a.position);  // twice the area long
  const Vector3<V> u = wind - per_corner_and_second * (a.moved + b.moved + c.moved);
  const V n2 = dot(n, n), un = dot(u, n);
  const V s = select(n2 > V(0), quarter_drag * abs(un) * un / n2, V(0));
  return s * n;
}

// Where a particle is one time step later. `force`, N, is the sum over its triangles: each gives a third to each
// corner.
template <class Real, class V>
[[gnu::always_inline]] inline Vector3<V> next_position(const Model<Real>& model, const Vector3<V>& position,
                                                       const Vector3<V>& moved, V inverse_mass,
                                                       const Vector3<V>& force) {
  const Vector3<V> gravity = {model.gravity.x, model.gravity.y, model.gravity.z};
  const V third_w = inverse_mass * Real(1. / 3);
  const Vector3<V> acceleration = gravity + third_w * force;
  const Vector3<V> next = position + model.velocity_factor * moved + (model.time_step * model.time_step) * acceleration;
  return select(inverse_mass > V(0), next, position);
}

}  // namespace lockstep::cloth
