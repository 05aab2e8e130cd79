// Contract: the system of the pressure that makes the liquid's velocity free of divergence, with a free surface of
// second order.
//
// A step of pressure changes the velocity of an open face between cells c and n by q(c) - q(n) (project.h). So that no
// liquid cell gains or loses volume,
//
//   sum over open faces of c of (q(c) - q(n)) = right(c), the sum of the velocities into c through open faces, m/s.
//
// Where n is liquid, q(n) is an unknown. Where n is air, the pressure is zero at the surface, which is at
// theta = phi(c) / (phi(c) - phi(n)) of the way from c to n. A pressure linear in between gives q(c) - q(n) =
// q(c) / theta. So
//
//   diagonal(c) = number of liquid neighbours + sum over air neighbours of 1 / max(theta, least_theta).
//
// Above an open top stands air of phi = 0. Closed faces (state.h) have no velocity. The matrix is symmetric, and
// positive definite but for pockets.
//
// A pocket is liquid that no open face connects with air: its pressure is known up to a constant, and the mean of
// `right` over it must be zero, or there is no solution. The mean is subtracted. A cell without open faces has no row.
//
// In:     fluid: phi and solid, velocity; finite.
// Out:    system, all of it.
// Errors: std::bad_alloc.
// Source: Gibou, Fedkiw, Cheng and Kang, A second-order-accurate symmetric discretization of the Poisson equation on
//         irregular domains, J. Comput. Phys. 176 (2002); Enright, Nguyen, Gibou and Fedkiw, Using the particle level
//         set method and a second order accurate pressure boundary condition for free surface flows (2003).
#pragma once

#include "common/math.h"
#include "common/production_fluid/state.h"
#include "common/production_fluid/system.h"

namespace lockstep::production_fluid {

// A nearer surface is treated as this near: larger values cost accuracy at the faces beside it, smaller ones
// conditioning.
inline constexpr double least_theta = 1e-3;

template <class Real>
using MakeSystem = void(const Fluid<Real>& fluid, System<Real>& system);

namespace serial {
MakeSystem<float> make_system;
MakeSystem<double> make_system;
}  // namespace serial

namespace openmp {
MakeSystem<float> make_system;
}  // namespace openmp

// Where the surface is between a liquid cell and an air cell: the share of the way from the first centre to the second.
template <class Number>
inline Number theta_between(const Number& phi, const Number& phi_of_air) {
  return max(phi / (phi - phi_of_air), Number(static_cast<float>(least_theta)));
}

// The coefficient of q(a) - q(b) at an open face: 1 between two liquid cells, 1 / theta at the surface, 0 between two
// air cells.
template <class Number>
inline Number coefficient_between(const Number& phi_a, const Number& phi_b) {
  const auto liquid_a = phi_a < Number(0), liquid_b = phi_b < Number(0);
  const auto both = liquid_a & liquid_b, either = liquid_a | liquid_b;
  if (none(either & !both)) return select(both, Number(1), Number(0));  // far from the surface: no divisions
  const Number theta = theta_between(select(liquid_a, phi_a, phi_b), select(liquid_a, phi_b, phi_a));
  return select(both, Number(1), select(either, Number(1) / theta, Number(0)));
}

// The row of a cell, face after face.
template <class Number>
struct Row {
  Number diagonal{0}, right{0};
};

// Adds a face of a liquid cell: `phi` is the cell's, the others are those of the cell beyond the face; `into` is the
// velocity through the face into the cell.
template <class Number>
inline void add_face(const Number& phi, const Number& phi_beyond, const Number& solid_beyond, const Number& into,
                     Row<Number>& row) {
  const auto open = !is_solid(solid_beyond);
  row.diagonal = row.diagonal + select(open, coefficient_between(phi, phi_beyond), Number(0));
  row.right = row.right + select(open, into, Number(0));
}

}  // namespace lockstep::production_fluid
