// The particles of the game fluid, one array a component.
#pragma once

#include <cstdint>

#include "common/arrays.h"
#include "common/vector3.h"

namespace lockstep::fluid {

// Owns its arrays; each holds padded(count) elements of which the first `count` count. After rebuild_grid the particles
// stand in cell order, so `id` is what tells which is which: input order, 0 .. count - 1.
template <class Real>
struct Particles {
  int count = 0;
  Array<std::int32_t> id;
  Vectors<Real> position;       // m, at time t
  Vectors<Real> half_velocity;  // m/s, at t - dt/2 before a step and t + dt/2 after it (leapfrog)
  Vectors<Real> velocity;       // m/s, at time t

  void resize(int n) {
    count = n;
    id.resize(padded(n));
    position.resize(n);
    half_velocity.resize(n);
    velocity.resize(n);
  }
};

template <Is<Particles> P, class F>
void for_each_array(P& p, const F& f) {
  f("id", p.id, p.count);
  f("position", p.position, p.count);
  f("half_velocity", p.half_velocity, p.count);
  f("velocity", p.velocity, p.count);
}

// Loads and stores the vector of particle i.
template <class Real>
inline Vector3<Real> at(const Vectors<Real>& vectors, int i) {
  return {vectors.x[i], vectors.y[i], vectors.z[i]};
}
template <class Real>
inline void put(Vectors<Real>& vectors, int i, const Vector3<Real>& vector) {
  vectors.x[i] = vector.x;
  vectors.y[i] = vector.y;
  vectors.z[i] = vector.z;
}

// Particle k of `to` becomes particle i of `from`.
template <class Real>
inline void copy_particle(const Particles<Real>& from, int i, Particles<Real>& to, int k) {
  to.id[k] = from.id[i];
  put(to.position, k, at(from.position, i));
  put(to.half_velocity, k, at(from.half_velocity, i));
  put(to.velocity, k, at(from.velocity, i));
}

}  // namespace lockstep::fluid
