// Contract: walls push back. A particle in a cell at a wall whose next position p + half_velocity * dt lies nearer to
// the wall than wall_reach, by depth > wall_min_depth, is accelerated inwards by wall_stiffness * depth and slowed by
// wall_damping * velocity. Does nothing where model.walls is false.
//
// In:      particles, at the positions that grid was rebuilt for.
// In, out: acceleration[i] for i < count, m/s^2.
// Source:  [LRB08] Figure 7, "Process Collisions"; notes/fluid.md.
#pragma once

#include "common/fluid/grid.h"
#include "common/fluid/particles.h"

namespace lockstep::fluid {

template <class Real>
using Collisions = void(const Model<Real>& model, const Grid<Real>& grid, const Particles<Real>& particles,
                        Vectors<Real>& acceleration);

namespace serial {
Collisions<float> collisions;
Collisions<double> collisions;
}  // namespace serial

namespace openmp {
Collisions<float> collisions;
}  // namespace openmp

}  // namespace lockstep::fluid
