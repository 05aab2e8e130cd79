// How one component of a particle moves, along one axis of the domain: the push of the walls, and the leapfrog.
//
// Source: [LRB08] Figure 7, "Process Collisions" and "Advance Particles"; notes/fluid.md.
#pragma once

#include "common/fluid/grid.h"

namespace lockstep::fluid {

// What the walls at the two ends of the axis add to the acceleration, m/s^2, of a particle at `position`, m, with these
// velocities, m/s.
template <class Real>
inline void push_back(const Model<Real>& model, const Axis<Real>& axis, Real position, Real half_velocity,
                      Real velocity, Real& acceleration) {
  const int cell = cell_coordinate(axis, position);
  const Real next = position + half_velocity * model.time_step;
  const Real depth_min = model.wall_reach - (next - axis.min);
  const Real depth_max = model.wall_reach - (axis.max - next);
  const Real push_min = model.wall_stiffness * depth_min - model.wall_damping * velocity;
  const Real push_max = model.wall_stiffness * depth_max + model.wall_damping * velocity;
  acceleration += cell == 0 && depth_min > model.wall_min_depth ? push_min : 0;
  acceleration -= cell == axis.cells - 1 && depth_max > model.wall_min_depth ? push_max : 0;
}

// How a particle moves along one axis: m, m/s, m/s.
template <class Real>
struct Movement {
  Real position, half_velocity, velocity;
};

// One time step of the leapfrog; a particle that went through a wall is mirrored at it. The compiler makes selects of
// these very conditions. Joined by &, the serial loop took 1.15 times as long; with && but without the nested ?:, or
// the other way around, the openmp loop took six times as long.
template <class Real>
inline Movement<Real> leapfrog(const Model<Real>& model, const Axis<Real>& axis, Real acceleration, Real position,
                               Real half_velocity) {
  const int cell = cell_coordinate(axis, position);
  Real hv = half_velocity + acceleration * model.time_step;
  Real p = position + hv * model.time_step;
  Real v = (half_velocity + hv) * Real(.5);

  const bool below = model.walls && cell == 0 && p < axis.min;
  const bool above = model.walls && cell == axis.cells - 1 && p > axis.max;
  p = below ? axis.min + (axis.min - p) : above ? axis.max - (p - axis.max) : p;
  const bool mirrored = below || above;
  v = mirrored ? -v : v;
  hv = mirrored ? -hv : hv;
  return {p, hv, v};
}

}  // namespace lockstep::fluid
