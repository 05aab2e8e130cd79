// Contract: one leapfrog step; particles that went through a wall are mirrored at it,
//
//   half_velocity += a dt,  p += half_velocity dt,  velocity = mean of the half velocities before and after;
//   a particle that began the step in a cell at a wall and ends beyond that wall is mirrored at it, and that component
//   of both its velocities is negated (where model.walls is true).
//
// In:      grid (shape only), acceleration[i], m/s^2.
// In, out: particles, at the positions that grid was rebuilt for.
// Source:  [LRB08] Figure 7, "Advance Particles"; notes/fluid.md.
#pragma once

#include "common/fluid/grid.h"
#include "common/fluid/particles.h"

namespace lockstep::fluid {

template <class Real>
using Advance = void(const Model<Real>& model, const Grid<Real>& grid, const Vectors<Real>& acceleration,
                     Particles<Real>& particles);

namespace serial {
Advance<float> advance;
Advance<double> advance;
}  // namespace serial

namespace openmp {
Advance<float> advance;
}  // namespace openmp

}  // namespace lockstep::fluid
