// The singular value decomposition of a 3x3 matrix by rotations: F = U diag(s) V^T, for a number or for lanes.
//
//   U, V     rotations: det = +1
//   s        s.x >= s.y >= |s.z| but for rounding, s.y >= 0; s.z < 0 where det F < 0, a tetrahedron that is inside out
//
// Jacobi's iteration turns F^T F to a diagonal matrix and collects its rotations in V, with angles that cost a root and
// a division. The columns of F V are then orthogonal but for rounding. They are sorted by length, and three Givens
// rotations make F V = U R; R's diagonal is s. What stands beside its diagonal is dropped.
//
// Error, measured: each entry of F - U diag(s) V^T is at most 1e-6 of F's greatest entry, over rotations with noise and
// matrices inverted, flat or with equal values; 1e-5 where values are (1, .01, -.0001). U U^T and V V^T are 1 to
// 1.2e-6. Where singular values are equal, the rotations are not unique.
//
// In: F, finite, with entries of at most 1e9. Where its greatest entry is below 1e-9, s and F are off by 1e-9.
// Source: McAdams, Selle, Tamstorf, Teran and Sifakis, Computing the singular value decomposition of 3x3 matrices with
//         minimal branching and elementary floating point operations, UW-Madison TR1690 (2011). The signs: Irving,
//         Teran and Fedkiw, Invertible finite elements for robust simulation of large deformation, SCA 2004.
#pragma once

#include <type_traits>

#include "common/rotation.h"

namespace lockstep::production_face {

template <class T>
struct Svd {
  Matrix3<T> u;
  Vector3<T> s;
  Matrix3<T> v;
};

// Four sweeps, as in the source, leave 4e-4 of F; from six on rounding is all there is, in double from eight on
// (notes/production_face.md).
template <class T>
inline constexpr int sweeps_of_jacobi = std::is_same_v<T, double> ? 8 : 6;

namespace svd_detail {

// An off-diagonal element counts as 0 up to this share of the sum of its two diagonal elements, in magnitude.
template <class T>
inline T negligible_to() {
  if constexpr (std::is_same_v<T, double>)
    return 1e-30;
  else
    return T(1e-12f);
}

// A symmetric matrix.
template <class T>
struct Symmetric {
  T xx, yy, zz, xy, xz, yz;
};

// Cosine and sine of half an angle.
template <class T>
struct HalfAngle {
  T cosine, sine;
};

// By about how much to turn [pp pq; pq qq] so that pq vanishes: exact where pq is small, and never by more than pi / 4.
// Where pq is as good as 0, not at all: squares of it would become denormal, which is slow.
template <class T>
inline HalfAngle<T> angle_to_diagonal(const T& pp, const T& pq, const T& qq) {
  constexpr double cosine = .92387953251128674, sine = .38268343236508977;  // of pi / 8
  const auto rests = abs(pq) <= negligible_to<T>() * (abs(pp) + abs(qq));
  const T c = select(rests, T(1), T(2) * (pp - qq)), s = select(rests, T(0), pq);
  const auto is_small = T(5.8284271247461901) * s * s < c * c;  // (1 + sqrt 2)^2
  const T scale = T(1) / sqrt(select(is_small, c * c + s * s, T(1)));
  return {select(is_small, scale * c, T(cosine)), select(is_small, scale * s, T(sine))};
}

// Turns the plane of axes p and q of a symmetric matrix; r is the third.
template <class T>
inline void turn(const HalfAngle<T>& half, T& pp, T& qq, T& pq, T& pr, T& qr) {
  const T c = half.cosine * half.cosine - half.sine * half.sine, s = T(2) * half.cosine * half.sine;
  const T along = c * pp + s * pq, across = c * pq + s * qq, beside = c * pq - s * pp, beyond = c * qq - s * pq;
  const T p = pr, q = qr;
  pp = c * along + s * across;
  qq = c * beyond - s * beside;
  pq = c * across - s * along;
  pr = c * p + s * q;
  qr = c * q - s * p;
}

// V and the diagonal of V^T A V.
template <class T>
inline Quaternion<T> diagonalize(Symmetric<T>& a) {
  Quaternion<T> v = {T(0), T(0), T(0), T(1)};
  for (int sweep = 0; sweep < sweeps_of_jacobi<T>; ++sweep) {
    const HalfAngle<T> z = angle_to_diagonal(a.xx, a.xy, a.yy);
    turn(z, a.xx, a.yy, a.xy, a.xz, a.yz);
    v = {z.cosine * v.x + z.sine * v.y, z.cosine * v.y - z.sine * v.x, z.cosine * v.z + z.sine * v.w,
         z.cosine * v.w - z.sine * v.z};
    const HalfAngle<T> x = angle_to_diagonal(a.yy, a.yz, a.zz);
    turn(x, a.yy, a.zz, a.yz, a.xy, a.xz);
    v = {x.cosine * v.x + x.sine * v.w, x.cosine * v.y + x.sine * v.z, x.cosine * v.z - x.sine * v.y,
         x.cosine * v.w - x.sine * v.x};
    const HalfAngle<T> y = angle_to_diagonal(a.zz, a.xz, a.xx);
    turn(y, a.zz, a.xx, a.xz, a.yz, a.xy);
    v = {y.cosine * v.x - y.sine * v.z, y.cosine * v.y + y.sine * v.w, y.cosine * v.z + y.sine * v.x,
         y.cosine * v.w - y.sine * v.y};
  }
  const T scale = T(1) / sqrt(v.x * v.x + v.y * v.y + v.z * v.z + v.w * v.w);
  return {scale * v.x, scale * v.y, scale * v.z, scale * v.w};
}

// Exchanges two columns where the second is longer, and turns one round, so that a rotation stays one.
template <class T>
inline void sort_columns(Vector3<T>& a, Vector3<T>& b, Vector3<T>& of_a, Vector3<T>& of_b, T& length_a, T& length_b) {
  const auto is_longer = length_a < length_b;
  const auto exchange = [&](Vector3<T>& first, Vector3<T>& second) {
    const Vector3<T> before = first;
    first = select(is_longer, second, first);
    second = select(is_longer, -before, second);
  };
  exchange(a, b), exchange(of_a, of_b);
  const T before = length_a;
  length_a = select(is_longer, length_b, length_a);
  length_b = select(is_longer, before, length_b);
}

// The rotation in the plane of two rows that makes `below` 0; `diagonal` becomes what is left of both, >= 0.
template <class T>
struct Givens {
  T c, s;

  Givens(T& diagonal, const T& below) {
    const T length = sqrt(diagonal * diagonal + below * below);
    const auto is_zero = length <= T(1e-18f);
    const T scale = T(1) / select(is_zero, T(1), length);
    c = select(is_zero, T(1), scale * diagonal), s = select(is_zero, T(0), scale * below);
    diagonal = select(is_zero, T(0), length);
  }
  void turn_rows(T& a, T& b) const {
    const T before = a;
    a = c * before + s * b;
    b = c * b - s * before;
  }
  void turn_columns(Vector3<T>& a, Vector3<T>& b) const {
    const Vector3<T> before = a;
    a = c * before + s * b;
    b = c * b - s * before;
  }
};

}  // namespace svd_detail

template <class T>
inline Svd<T> svd(const Matrix3<T>& f) {
  using namespace svd_detail;
  Symmetric<T> a = {dot(f.x, f.x), dot(f.y, f.y), dot(f.z, f.z), dot(f.x, f.y), dot(f.x, f.z), dot(f.y, f.z)};
  Svd<T> found;
  Matrix3<T>& v = found.v;
  v = matrix_of(diagonalize(a));
  Matrix3<T> b = {f * v.x, f * v.y, f * v.z};
  T x = dot(b.x, b.x), y = dot(b.y, b.y), z = dot(b.z, b.z);
  sort_columns(b.x, b.y, v.x, v.y, x, y);
  sort_columns(b.x, b.z, v.x, v.z, x, z);
  sort_columns(b.y, b.z, v.y, v.z, y, z);

  Matrix3<T>& u = found.u;
  u = {{T(1), T(0), T(0)}, {T(0), T(1), T(0)}, {T(0), T(0), T(1)}};
  const Givens<T> first(b.x.x, b.x.y);
  first.turn_rows(b.y.x, b.y.y), first.turn_rows(b.z.x, b.z.y), first.turn_columns(u.x, u.y);
  const Givens<T> second(b.x.x, b.x.z);
  second.turn_rows(b.y.x, b.y.z), second.turn_rows(b.z.x, b.z.z), second.turn_columns(u.x, u.z);
  const Givens<T> third(b.y.y, b.y.z);
  third.turn_rows(b.z.y, b.z.z), third.turn_columns(u.y, u.z);
  found.s = {b.x.x, b.y.y, b.z.z};
  return found;
}

}  // namespace lockstep::production_face
