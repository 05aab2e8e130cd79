// Contract: moves bodies on by a step dt, s, by semi-implicit Euler.
//
// Positions: x += v dt. Orientations: the midpoint rule. Angular velocities keep the angular momentum
// (common/rigid/spin.h). Bodies move by `moving`, the mean velocities of the step with position correction, m/s and
// rad/s. bodies.motion has the velocities that they keep. moving[body] is padded to whole vectors, like all arrays of
// bodies. Static bodies do not change.
//
// In: moving, dt, bodies.inverse_mass. In, out: bodies.pose, bodies.motion.
// Source: [LRB08] "Rigid Body Simulation": velocity and position by integrating F = m a.
#pragma once

#include <span>

#include "common/rigid/world.h"

namespace lockstep::rigid {

template <class Real>
using Integrate = void(std::span<const Motion<Real>> moving, Real dt, Bodies<Real>& bodies);

namespace serial {
Integrate<float> integrate;
Integrate<double> integrate;
}  // namespace serial

namespace openmp {
Integrate<float> integrate;
}  // namespace openmp

}  // namespace lockstep::rigid
