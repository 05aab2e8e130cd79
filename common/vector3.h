// Three components: of one point (Vector3), of sixteen (Vector3<floatv>), and of many, one array a component (Vectors).
#pragma once

#include <type_traits>

#include "common/array.h"
#include "common/math.h"

namespace lockstep {

template <class T>
struct Vector3 {
  T x, y, z;
};

// One order of operations for scalars and lanes, so that both give the same bits.
template <class T>
inline Vector3<T> operator+(const Vector3<T>& a, const Vector3<T>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class T>
inline Vector3<T> operator-(const Vector3<T>& a, const Vector3<T>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class T>
inline Vector3<T> operator-(const Vector3<T>& a) {
  return {-a.x, -a.y, -a.z};
}
template <class T>
inline Vector3<T> operator*(const std::type_identity_t<T>& s, const Vector3<T>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class T>
inline T dot(const Vector3<T>& a, const Vector3<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
inline Vector3<T> cross(const Vector3<T>& a, const Vector3<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
// mask ? a : b, where T is a scalar and Mask bool, or T is floatv and Mask maskv.
template <class T, class Mask>
inline Vector3<T> select(const Mask& mask, const Vector3<T>& a, const Vector3<T>& b) {
  return {select(mask, a.x, b.x), select(mask, a.y, b.y), select(mask, a.z, b.z)};
}

template <class Real>
struct Vectors {
  Array<Real> x, y, z;

  // Room for n vectors, padded for lanes; what is new is zero.
  void resize(std::size_t n) {
    for (Array<Real>* component : {&x, &y, &z}) component->resize(padded(n));
  }
};

// Vector i of many.
template <class Real>
Vector3<Real> load(const Vectors<Real>& v, std::size_t i) {
  return {v.x[i], v.y[i], v.z[i]};
}
template <class Real>
void store(Vectors<Real>& v, std::size_t i, const Vector3<Real>& value) {
  v.x[i] = value.x, v.y[i] = value.y, v.z[i] = value.z;
}

}  // namespace lockstep
