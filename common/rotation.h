// 3x3 matrices and unit quaternions. For T a scalar or floatv, in the same order of operations.
#pragma once

#include "common/vector3.h"

namespace lockstep {

// x i + y j + z k + w; of length 1 where it is a rotation.
template <class T>
struct Quaternion {
  T x, y, z, w;
};

// Columns: where the axes go.
template <class T>
struct Matrix3 {
  Vector3<T> x, y, z;
};

template <class T>
inline Quaternion<T> operator*(const Quaternion<T>& a, const Quaternion<T>& b) {
  return {a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
          a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}

template <class T>
inline Quaternion<T> conjugate(const Quaternion<T>& q) {
  return {-q.x, -q.y, -q.z, q.w};
}

template <class T>
inline Matrix3<T> matrix_of(const Quaternion<T>& q) {
  const T one(1), x2 = q.x + q.x, y2 = q.y + q.y, z2 = q.z + q.z;
  const T xx = q.x * x2, yy = q.y * y2, zz = q.z * z2;
  const T xy = q.x * y2, xz = q.x * z2, yz = q.y * z2;
  const T wx = q.w * x2, wy = q.w * y2, wz = q.w * z2;
  return {
      {one - (yy + zz), xy + wz, xz - wy}, {xy - wz, one - (xx + zz), yz + wx}, {xz + wy, yz - wx, one - (xx + yy)}};
}

// M v, and the transpose of M times v. The transpose of a rotation is its inverse.
template <class T>
inline Vector3<T> operator*(const Matrix3<T>& m, const Vector3<T>& v) {
  return {m.x.x * v.x + m.y.x * v.y + m.z.x * v.z, m.x.y * v.x + m.y.y * v.y + m.z.y * v.z,
          m.x.z * v.x + m.y.z * v.y + m.z.z * v.z};
}
template <class T>
inline Vector3<T> transposed_times(const Matrix3<T>& m, const Vector3<T>& v) {
  return {dot(m.x, v), dot(m.y, v), dot(m.z, v)};
}

}  // namespace lockstep
