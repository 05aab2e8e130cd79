// Contract: particles move with the liquid.
//
//   ahead = p + dt u(p),   p += dt (u(p) + u(ahead)) / 2
//
// by the velocity u at the beginning: Heun's method, whose error in one step is of third order in dt. Then a particle
// that is nearer than .1 h to an obstacle is pushed away from it, along the slope of the obstacles' distance, by what
// is missing; and one that is nearer than that to a side of the box is put there. .1 h is the least radius: particles
// touch walls, and do not reach into them. Where two obstacles meet, a particle may stay too near; remove_particles
// takes those that are inside.
//
// An open top is a side, too: what is above is air without particles.
//
// In:      fluid: the grid, and solid, a distance (its slope is at most 1); faces, finite, as is their padding; dt, s.
// In, out: particles' positions. `first` holds no longer.
// Source:  Enright, Losasso and Fedkiw, Comput. Struct. 83 (2005); [ITJ07] "Production Fluid".
#pragma once

#include "common/math.h"
#include "common/production_fluid/particles.h"
#include "common/production_fluid/state.h"
#include "common/production_fluid/trace.h"

namespace lockstep::production_fluid {

template <class Real>
using AdvectParticles = void(const Fluid<Real>& fluid, const Faces<Real>& faces, Real dt, Particles<Real>& particles);

namespace serial {
AdvectParticles<float> advect_particles;
AdvectParticles<double> advect_particles;
}  // namespace serial

namespace openmp {
AdvectParticles<float> advect_particles;
}  // namespace openmp

// --- Formulas; of numbers or of lanes

// A position that the box holds; `margin` and the result are m.
template <class Number, class Real>
inline Vector3<Number> kept_in_box(const Vector3<Number>& p, const Fluid<Real>& fluid, Real margin) {
  const auto along = [&](const Number& x, int n) {
    return min(max(x, Number(margin)), Number(Real(n) * fluid.spacing - margin));
  };
  return {along(p.x, fluid.nx), along(p.y, fluid.ny), along(p.z, fluid.nz)};
}

// How far to move a particle at distance `solid` from obstacles. `slope` is that of the distance; where it vanishes,
// there is no way out.
template <class Number>
inline Vector3<Number> push_out(const Number& solid, const Number& margin, const Vector3<Number>& slope) {
  const Number length = sqrt(dot(slope, slope));
  const auto near = (solid < margin) & (length > Number(0));
  return select(near, (margin - solid) / select(near, length, Number(1)), Number(0)) * slope;
}

// No obstacle is within the margin of a particle whose block begins at a cell so far from obstacles, in cells: from
// there it is at most sqrt(3) cells to the particle.
inline constexpr float far_from_obstacles = 2;

}  // namespace lockstep::production_fluid
