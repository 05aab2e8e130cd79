// Contract: gravity changes the velocity of the liquid, u += dt g, on every face.
//
// Closed faces and faces in the air get it, too: project sets the former to zero, and extrapolate overwrites the
// latter.
//
// In:     gravity, m/s^2; dt, s; faces, finite.
// Out:    faces. A component whose gravity is zero keeps its bits. Padding is not changed.
// Source: Bridson, Fluid Simulation for Computer Graphics (2nd ed., 2015), 2.2.
#pragma once

#include "common/production_fluid/state.h"

namespace lockstep::production_fluid {

template <class Real>
using ApplyForces = void(const Vector3<Real>& gravity, Real dt, Faces<Real>& faces);

namespace serial {
ApplyForces<float> apply_forces;
ApplyForces<double> apply_forces;
}  // namespace serial

namespace openmp {
ApplyForces<float> apply_forces;
}  // namespace openmp

}  // namespace lockstep::production_fluid
