// Contract: one step of Verlet integration under gravity, wind and drag,
//
//   p_next = p + (p - p_previous) velocity_factor + a dt^2
//   a = gravity + w / 3 sum over the particle's triangles of f
//   f = drag / 4 |u . N| (u . N) / |N|^2 N   of a triangle
//
// with N = (b - a) x (c - a), twice the triangle's area long, and u the air's velocity relative to the mean of its
// corners' velocities (p - p_previous) / dt.
//
// f is the dynamic pressure drag / 2 (u . n)^2 times the triangle's area, along its normal n, from whichever side the
// air comes. Still air gives drag, moving air wind; air along the cloth exerts no force. The force on a triangle
// without area is 0. Pinned particles (w = 0) do not move.
//
// In, out: cloth.position and cloth.previous, m. Scratch: cloth.force.
// Source:  [Jakobsen 2001] section 2; [LRB08] "Cloth Simulation" and [ITJ07] "Game Cloth" for the forces; the dynamic
//          pressure is textbook aerodynamics.
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
