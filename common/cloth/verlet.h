// Contract: one step of Verlet integration under gravity, wind and drag,
//
//   p_next = p + (p - p_previous) kept_velocity + a dt^2,   a = gravity + w / 3 sum over the particle's triangles of f,
//   f = drag / 4 |u . N| (u . N) / |N|^2 N   of a triangle with N = (b - a) x (c - a), twice its area long, and the air's velocity u
//   relative to the mean of its corners' velocities (p - p_previous) / dt:
//
// the dynamic pressure drag / 2 (u . n)^2 on its area, along its normal n, from whichever side the air comes. Still air then is
// drag, moving air is wind, and air along the cloth does nothing. Triangles without area feel no wind. Pinned particles stay.
//
// In, out: cloth.position and cloth.previous, m. Scratch: cloth.force.
// Source:  [Jakobsen 2001] section 2; [LRB08] "Cloth Simulation" and [ITJ07] "Game Cloth" for the forces; the dynamic pressure is
//          textbook aerodynamics.
#pragma once

#include "common/cloth/cloth.h"

namespace lockstep::cloth {

template <class Real>
using Verlet = void(Cloth<Real>& cloth);

namespace serial {
Verlet<float> verlet;
Verlet<double> verlet;
}  // namespace serial

namespace openmp {
Verlet<float> verlet;
}  // namespace openmp

}  // namespace lockstep::cloth
