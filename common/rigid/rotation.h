// Poses of bodies and colliders.
#pragma once

#include "common/rotation.h"

namespace lockstep::rigid {

// The pose of a body or a collider: position of its origin, m, and orientation. Lanes load the record of eight numbers
// whole.
template <class T>
struct alignas(8 * sizeof(T)) Pose {
  Vector3<T> position;
  Quaternion<T> orientation;
  T unused;
};

}  // namespace lockstep::rigid
