// Rigid motions that scenes give to bones and bodies.
#pragma once

#include <cmath>

#include "common/rotation.h"

namespace lockstep {

// Where something rigid is: turned about its pivot, by the length of `turn` about its direction, then shifted.
struct Placement {
  Vector3<double> turn = {0, 0, 0};   // rad
  Vector3<double> shift = {0, 0, 0};  // m
};

// Rodrigues' formula.
inline Matrix3<double> rotation_by(const Vector3<double>& turn) {
  const double angle = std::sqrt(dot(turn, turn));
  if (angle == 0) return {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const Vector3<double> axis = (std::sin(.5 * angle) / angle) * turn;
  return matrix_of(Quaternion<double>{axis.x, axis.y, axis.z, std::cos(.5 * angle)});
}

}  // namespace lockstep
