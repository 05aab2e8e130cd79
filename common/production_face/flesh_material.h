// Flesh: a Mooney-Rivlin material whose energy goes on beyond the point where it is crushed or inside out. For a number
// or for lanes.
//
//   psi = m10 (j I - 3) + m01 (j^2 (I^2 - II) / 2 - 3) + kappa / 2 L^2,   j = J^(-2/3), L = ln J,
//
// where I, II and J are the sum of squares, the sum of fourth powers and the product of the singular values of F. The
// first two terms resist a change of shape, the last one of volume. As strains become small, the shear modulus is
// 2 (m10 + m01) and the bulk modulus is kappa.
//
// Where J < crushed, L and j go on as the parabolas that have their value, slope and curvature there. So psi, P and the
// derivative of P are defined and continuous for every F, and psi grows as a tetrahedron turns inside out.
//
// P and its derivative need no division by a singular value or by a difference of two. With c_i the product of the
// other two singular values, the derivatives of psi by I, II and J being p1, p2 and p3,
//
//   P_i = 2 p1 s_i + 4 p2 s_i^3 + p3 c_i,   P = U diag(P_i) V^T,
//
// and in the frames of U and V, dP = a : dF falls into one 3x3 block of the diagonal and three 2x2 blocks
// [alpha beta; beta alpha] of pairs ij, ji.
//
// Source: Teran, Sifakis, Irving and Fedkiw, Robust quasistatic finite elements and flesh simulation, SCA 2005. Beyond
//         the crushed state: Stomakhin, Howes, Schroeder and Teran, Energetically consistent invertible elasticity,
//         SCA 2012, do likewise in singular values.
#pragma once

#include "common/math.h"
#include "common/transcendental.h"
#include "common/vector3.h"

namespace lockstep::production_face {

// Pa. Those of [ITJ07]'s flesh, as PARSEC's facesim has them.
struct Flesh {
  float m10 = 6e4f, m01 = 2e4f, kappa = 3e6f;
};

inline constexpr float crushed = .1f;  // the J below which the energy goes on as parabolas

// A function of J, its slope and its curvature.
template <class T>
struct Jet {
  T value, slope, curvature;
};

namespace flesh_detail {

// The parabola of a function at `crushed` where J is less, else the function.
template <class T>
inline Jet<T> beyond_crushed(const Jet<T>& at, const T& step) {
  return {at.value + step * (at.slope + T(.5f) * step * at.curvature), at.slope + step * at.curvature, at.curvature};
}

}  // namespace flesh_detail

// How psi changes with I, II and J; and the second derivatives that are not 0.
template <class T>
struct FleshSlopes {
  T energy, by_i, by_ii, by_j;
  T by_i_i, by_i_j, by_ii_j, by_j_j;
};

template <class T>
inline FleshSlopes<T> flesh_slopes(const Flesh& flesh, const Vector3<T>& s) {
  using flesh_detail::beyond_crushed;
  const T m10(flesh.m10), m01(flesh.m01), kappa(flesh.kappa);
  const T xx = s.x * s.x, yy = s.y * s.y, zz = s.z * s.z;
  const T i = xx + yy + zz, pairs = xx * yy + yy * zz + zz * xx;  // (I^2 - II) / 2
  const T volume = s.x * s.y * s.z, bounded = max(volume, T(crushed)), step = volume - bounded;
  const T per_volume = T(1) / bounded, root = cbrt(bounded);
  const T j = T(1) / (root * root);
  const Jet<T> shape =
      beyond_crushed<T>({j, T(-2.f / 3) * j * per_volume, T(10.f / 9) * j * per_volume * per_volume}, step);
  const Jet<T> strain = beyond_crushed<T>({log(bounded), per_volume, -(per_volume * per_volume)}, step);

  const T twice = T(2) * m01 * pairs;
  FleshSlopes<T> d;
  d.energy = m10 * (shape.value * i - T(3)) + m01 * (shape.value * shape.value * pairs - T(3)) +
             T(.5f) * kappa * strain.value * strain.value;
  d.by_i_i = m01 * shape.value * shape.value;
  d.by_i = m10 * shape.value + d.by_i_i * i;
  d.by_ii = T(-.5f) * d.by_i_i;
  d.by_j = shape.slope * (m10 * i + twice * shape.value) + kappa * strain.value * strain.slope;
  d.by_i_j = shape.slope * (m10 + T(2) * m01 * shape.value * i);
  d.by_ii_j = -(m01 * shape.value * shape.slope);
  d.by_j_j = shape.curvature * (m10 * i + twice * shape.value) + twice * shape.slope * shape.slope +
             kappa * (strain.slope * strain.slope + strain.value * strain.curvature);
  return d;
}

// The stress along the principal axes, Pa.
template <class T>
inline Vector3<T> principal_stress(const FleshSlopes<T>& d, const Vector3<T>& s) {
  const T a = T(2) * d.by_i, b = T(4) * d.by_ii;
  const auto stress = [&](const T& x, const T& cofactor) { return (a + b * (x * x)) * x + d.by_j * cofactor; };
  return {stress(s.x, s.y * s.z), stress(s.y, s.z * s.x), stress(s.z, s.x * s.y)};
}

// The derivative of the stress in the frames of U and V, Pa: dP_ii = sum_j diagonal_ij dF_jj, and for i != j
// dP_ij = alpha_ij dF_ij + beta_ij dF_ji. Pairs are named by their axes.
template <class T>
struct StressDerivative {
  T xx, yy, zz, xy, yz, zx;  // the block of the diagonal, which is symmetric
  Vector3<T> alpha, beta;    // .x of the pair yz, .y of zx, .z of xy
};

template <class T>
inline StressDerivative<T> stress_derivative(const FleshSlopes<T>& d, const Vector3<T>& s) {
  const T xx = s.x * s.x, yy = s.y * s.y, zz = s.z * s.z;
  const Vector3<T> c = {s.y * s.z, s.z * s.x, s.x * s.y};
  const T a = T(2) * d.by_i, b = T(4) * d.by_ii, of_squares = T(4) * d.by_i_i;
  // u_i c_j + u_j c_i is what the mixed terms, of I with J and of II with J, give to psi's derivative by s_i and s_j.
  const auto u = [&](const T& x, const T& square) { return x * (T(2) * d.by_i_j + T(4) * d.by_ii_j * square); };
  const Vector3<T> mixed = {u(s.x, xx), u(s.y, yy), u(s.z, zz)};
  const auto same = [&](const T& square, const T& m, const T& cofactor) {
    return a + T(3) * b * square + of_squares * square + T(2) * m * cofactor + d.by_j_j * cofactor * cofactor;
  };
  const auto other = [&](const T& third, const T& x, const T& y, const T& mx, const T& my, const T& cx, const T& cy) {
    return d.by_j * third + of_squares * (x * y) + mx * cy + my * cx + d.by_j_j * cx * cy;
  };
  return {same(xx, mixed.x, c.x),
          same(yy, mixed.y, c.y),
          same(zz, mixed.z, c.z),
          other(s.z, s.x, s.y, mixed.x, mixed.y, c.x, c.y),
          other(s.x, s.y, s.z, mixed.y, mixed.z, c.y, c.z),
          other(s.y, s.z, s.x, mixed.z, mixed.x, c.z, c.x),
          {a + b * (yy + zz), a + b * (zz + xx), a + b * (xx + yy)},
          {b * c.x - d.by_j * s.x, b * c.y - d.by_j * s.y, b * c.z - d.by_j * s.z}};
}

}  // namespace lockstep::production_face
