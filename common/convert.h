// Numbers in another precision. Widening float to double is exact: the double run then solves the very problem that the
// float run solves, and the difference is the float run's rounding.
#pragma once

#include "common/array.h"
#include "common/vector3.h"

namespace lockstep {

template <class To, class From>
Array<To> convert(const Array<From>& array) {
  return Array<To>(array.begin(), array.end());
}

template <class To, class From>
Vectors<To> convert(const Vectors<From>& v) {
  return {convert<To>(v.x), convert<To>(v.y), convert<To>(v.z)};
}

template <class To, class From>
Vector3<To> convert(const Vector3<From>& v) {
  return {static_cast<To>(v.x), static_cast<To>(v.y), static_cast<To>(v.z)};
}

}  // namespace lockstep
