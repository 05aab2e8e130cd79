// The particles of the game fluid, one array a component.
#pragma once

#include <cstdint>

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

}  // namespace lockstep::fluid
