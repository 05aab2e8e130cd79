// Contract: bodies moved by a step, semi-implicit Euler: by the velocities that the solver found.
//
// x += v dt; orientations by the midpoint rule, and angular velocities by what keeps the angular momentum (common/rigid/spin.h). The
// velocities to move with are `moving` (the mean ones of the step, with position correction), with room for whole vectors like all that
// bodies have; bodies.motion is what bodies keep.
//
// In, out: bodies.pose, bodies.motion. In: dt, s.
// Source:  [LRB08] "Rigid Body Simulation": velocity and position by integrating F = m a.
#pragma once

#include <span>

#include "common/rigid/world.h"

namespace lockstep::rigid {

template <class Real>
using AdvanceBodies = void(std::span<const Motion<Real>> moving, Real dt, Bodies<Real>& bodies);

namespace serial {
AdvanceBodies<float> advance_bodies;
AdvanceBodies<double> advance_bodies;
}  // namespace serial

namespace openmp {
AdvanceBodies<float> advance_bodies;
}  // namespace openmp

}  // namespace lockstep::rigid
