// What both versions of sweep and prune choose the axis by.
#pragma once

#include "common/spatial/bounds.h"

namespace lockstep::spatial {

inline constexpr int sum_block = 1024;  // sums run over blocks of so many colliders, and then over the blocks

template <class T>
const T& along(const Vector3<T>& v, int axis) {
  return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}
template <class Real>
const Array<Real>& along(const Vectors<Real>& v, int axis) {
  return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

template <class T>
Vector3<T> twice_centre(const Box<T>& box) {
  return box.low + box.high;
}
template <class T>
Vector3<T> squares(const Vector3<T>& v) {
  return {v.x * v.x, v.y * v.y, v.z * v.z};
}

// The axis of the greatest component, the first of equals.
template <class T>
int greatest(const Vector3<T>& v) {
  return v.x >= v.y ? (v.x >= v.z ? 0 : 2) : (v.y >= v.z ? 1 : 2);
}

}  // namespace lockstep::spatial
