// The forces of one strained tetrahedron on its corners. For a number or for lanes.
//
//   f_a = -volume P gradient_a,   f_0 = -(f_1 + f_2 + f_3)
//
// They are minus the slope of the energy by the corners' displacements; the columns of -volume P Dm^-T.
// Source: Teran, Blemker, Ng-Thow-Hing and Fedkiw, Finite volume methods for the simulation of skeletal muscle, SCA
//         2003.
#pragma once

#include "common/production_face/parts.h"
#include "common/rotation.h"

namespace lockstep::production_face {

// field(array, k) is field k of `array`, of the one element or of the sixteen that T holds.
template <class T, class Real, class Field>
Parts<T> element_forces(const Body<Real>& body, const Strained<Real>& strained, const Field& field) {
  const auto vector = [&](const Blocked<Real>& array, int k) {
    return Vector3<T>{field(array, k), field(array, k + 1), field(array, k + 2)};
  };
  const Matrix3<T> stress = {vector(strained.stress, 0), vector(strained.stress, 3), vector(strained.stress, 6)};
  const T volume = field(body.volume, 0);
  Parts<T> force;
  for (int a = 1; a < 4; ++a) force.of[a] = -volume * (stress * vector(body.gradient, 3 * a - 3));
  set_first_corner(force);
  return force;
}

}  // namespace lockstep::production_face
