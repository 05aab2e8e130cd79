// Contract: the pressure takes the divergence out of the liquid's velocity.
//
// An open face between the cells a, before it, and b, behind it, gets
//
//   u -= coefficient (q(b) - q(a)),
//
// where q is the solution of the system (system.h) and 0 in the air. The coefficient is what the face adds to the
// system's diagonal, by the same function (make_system.h): with another clamp, divergence would stay in the cells
// beside the face.
//
// A closed face gets 0, the velocity of what closes it. A face between two air cells, or between air and the outside of
// an open top, keeps its velocity.
//
// Differences of q are taken in double, because float would round q by more than what neighbours differ by in deep
// liquid. A face rounds once to Real.
//
// In:     fluid: phi and solid; system: `cells` alone; q, bordered likewise, 0 in cells without a row.
// In, out: faces, which may be fluid.velocity itself. Padding is not changed.
// Source: Enright, Nguyen, Gibou and Fedkiw, Using the particle level set method and a second order accurate pressure
//         boundary condition for free surface flows (2003).
#pragma once

#include "common/production_fluid/make_system.h"
#include "common/production_fluid/state.h"
#include "common/production_fluid/system.h"

namespace lockstep::production_fluid {

template <class Real>
using Project = void(const Fluid<Real>& fluid, const System<Real>& system, const Array<double>& q, Faces<Real>& faces);

namespace serial {
Project<float> project;
Project<double> project;
}  // namespace serial

namespace openmp {
Project<float> project;
}  // namespace openmp

// --- Formulas; of numbers or of lanes

// The velocity of an open face after the pressure has changed it. Double: a double or lanes of it.
template <class Double>
inline Double pushed(const Double& velocity, const Double& coefficient, const Double& q_a, const Double& q_b) {
  return velocity - coefficient * (q_b - q_a);
}

}  // namespace lockstep::production_fluid
