// Contract: the pressure takes the divergence out of the liquid's velocity.
//
// An open face between the cells a, before it, and b, behind it, gets
//
//   u -= coefficient (q(b) - q(a)),
//
// where q is the solution of the system (system.h) and 0 in the air. The coefficient is what the face adds to the
// system's diagonal (make_system.h): 1 between two liquid cells, and 1 / max(theta, least_theta) at the surface, with
// the bits that it has there. A clamp here that differs from the one there leaves divergence in the cells beside it.
//
// A closed face gets 0, the velocity of what closes it. A face between two air cells, or between air and the outside of
// an open top, keeps its velocity.
//
// Differences of q are taken in double, because float would round q by more than what neighbours differ by in deep
// liquid. A face rounds once to Real.
//
// In:     fluid: phi and solid; cells, and q in their order, 0 in cells without a row; velocities in faces.
// Out:    faces, of which fluid.velocity may be one with. Padding is not changed.
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

// Whether neither of the cells beside a face is solid or a wall.
template <class Number>
inline auto is_open(const Number& solid_a, const Number& solid_b) {
  return (solid_a >= Number(0)) & (solid_b >= Number(0));
}

// What the difference of q between the cells of an open face counts.
template <class Number>
inline Number coefficient_between(const Number& phi_a, const Number& phi_b) {
  const auto liquid_a = phi_a < Number(0), liquid_b = phi_b < Number(0);
  const Number theta = theta_between(select(liquid_a, phi_a, phi_b), select(liquid_a, phi_b, phi_a));
  return select(liquid_a & liquid_b, Number(1), select(liquid_a | liquid_b, Number(1) / theta, Number(0)));
}

// The velocity of an open face behind the pressure's push. Double: a double or lanes of it.
template <class Double>
inline Double pushed(const Double& velocity, const Double& coefficient, const Double& q_a, const Double& q_b) {
  return velocity - coefficient * (q_b - q_a);
}

}  // namespace lockstep::production_fluid
