// How the forces of links, membranes and hinges fall as their corners move and as they speed up: for each two corners a
// and c the 3x3 block
//
//   square K_ac + step D_ac,   K_ac = the definite part of -df_a/dx_c,   D_ac = -df_a/dv_c
//
// square = h^2 and step = h for a time step h. Of a number or of lanes. K_ca is K_ac^T. Where all corners move alike no
// force changes, so that K_aa is minus the sum of a's other blocks: elements give none of it.
//
// x^T K x >= 0 for every element but links of quadratic bending, whose sum alone is definite:
//
//   springs     k (r I + (1 - r) u u^T), r = 1 - L / l, but 0 where the spring is compressed
//   membranes   exact but for negative parts: of St. Venant and Kirchhoff's, the term that turns with the stress takes
//               the positive part of S; of co-rotated ones, each negative eigenvalue counts as 0
//   hinges      the part by which the torque changes with theta, k |e|^2 / (|N1| + |N2|) cos(theta / 2) / 2 u_a u_c^T
//   quadratic   Q
//
// Source: Baraff and Witkin, Large steps in cloth simulation, SIGGRAPH 1998; Choi and Ko, Stable but responsive cloth,
//         SIGGRAPH 2002 (springs); Smith, de Goes and Kim, Analytic eigensystems for isotropic distortion energies, ACM
//         Trans. Graph. 38 (2019).
#pragma once

#include "common/production_cloth/element_forces.h"

namespace lockstep::production_cloth {

// A 3x3 block, row by row.
template <class T>
struct Block {
  T e[9];
};

template <class T>
inline Block<T> operator+(const Block<T>& a, const Block<T>& b) {
  Block<T> sum;
  for (int i = 0; i < 9; ++i) sum.e[i] = a.e[i] + b.e[i];
  return sum;
}
template <class T>
inline Block<T> operator*(const std::type_identity_t<T>& s, const Block<T>& a) {
  Block<T> product;
  for (int i = 0; i < 9; ++i) product.e[i] = s * a.e[i];
  return product;
}
template <class T>
inline Block<T> operator-(const Block<T>& a) {
  Block<T> negative;
  for (int i = 0; i < 9; ++i) negative.e[i] = -a.e[i];
  return negative;
}
template <class T>
inline Block<T> transposed(const Block<T>& a) {
  return {{a.e[0], a.e[3], a.e[6], a.e[1], a.e[4], a.e[7], a.e[2], a.e[5], a.e[8]}};
}
template <class T>
inline Vector3<T> operator*(const Block<T>& a, const Vector3<T>& v) {
  return {a.e[0] * v.x + a.e[1] * v.y + a.e[2] * v.z, a.e[3] * v.x + a.e[4] * v.y + a.e[5] * v.z,
          a.e[6] * v.x + a.e[7] * v.y + a.e[8] * v.z};
}
// a b^T.
template <class T>
inline Block<T> outer(const Vector3<T>& a, const Vector3<T>& b) {
  return {{a.x * b.x, a.x * b.y, a.x * b.z, a.y * b.x, a.y * b.y, a.y * b.z, a.z * b.x, a.z * b.y, a.z * b.z}};
}
template <class T>
inline Block<T> on_diagonal(const T& s) {
  const T none(0);
  return {{s, none, none, none, s, none, none, none, s}};
}

// What K and D are multiplied by.
template <class T>
struct Scales {
  T square, step;
};

// --- Links; K_ac of their two ends. d, m: from one end to the other

template <class T>
inline Block<T> stiffness_of_spring(const Scales<T>& scales, const T& rest_length, const T& stiffness,
                                    const T& root_of_damping, const Vector3<T>& d) {
  const T length = sqrt(dot(d, d)), inverse = T(1) / max(length, T(1e-15f));
  const Vector3<T> direction = inverse * d;
  const T tension = max((length - rest_length) * inverse, T(0)), k = scales.square * stiffness;
  const T along = k * (T(1) - tension) + scales.step * (root_of_damping * root_of_damping);
  return -(on_diagonal(k * tension) + along * outer(direction, direction));
}

// weight, N/m, of quadratic bending.
template <class T>
inline Block<T> stiffness_of_bending(const Scales<T>& scales, const T& bend_damping, const T& weight) {
  return on_diagonal(-((scales.square + scales.step * bend_damping) * weight));
}

// --- Membranes

// dP of dF, by columns: dP_x = xx dF_x + xy dF_y, dP_y = xy^T dF_x + yy dF_y.
template <class T>
struct StressDerivative {
  Block<T> xx, xy, yy;
};

template <class T>
struct Symmetric2 {
  T xx, xy, yy;
};

// Eigenvalues below 0 made 0.
template <class T>
inline Symmetric2<T> positive_part(const Symmetric2<T>& s) {
  const T middle = T(.5f) * (s.xx + s.yy), half = T(.5f) * (s.xx - s.yy), off = sqrt(half * half + s.xy * s.xy);
  const T upper = max(middle + off, T(0)), lower = max(middle - off, T(0));
  const auto is_apart = off > T(0);
  const T share = select(is_apart, (upper - lower) / select(is_apart, off + off, T(1)), T(0));
  const T mean = T(.5f) * (upper + lower);
  return {mean + share * half, share * s.xy, mean - share * half};
}

// Of F C[F^T dF + dF^T F] / 2, C[E] = lambda tr(E) I + 2 mu E: of stress that follows from the rate of E.
template <class T>
inline StressDerivative<T> by_strain(const T& lambda, const T& mu, const Columns<T>& f) {
  const Block<T> xx = outer(f.x, f.x), xy = outer(f.x, f.y), yy = outer(f.y, f.y), both = mu * (xx + yy);
  return {(lambda + mu) * xx + both, lambda * xy + mu * transposed(xy), (lambda + mu) * yy + both};
}

// Of St. Venant and Kirchhoff's P, what turns with the stress.
template <class T>
inline StressDerivative<T> by_turning_of_stress(const T& lambda, const T& mu, const Columns<T>& f) {
  const T half(.5f), exx = half * (dot(f.x, f.x) - T(1)), eyy = half * (dot(f.y, f.y) - T(1));
  const T pressure = lambda * (exx + eyy), twice = mu + mu;
  const Symmetric2<T> s = positive_part<T>({pressure + twice * exx, mu * dot(f.x, f.y), pressure + twice * eyy});
  return {on_diagonal(s.xx), on_diagonal(s.xy), on_diagonal(s.yy)};
}

// Of the co-rotated P (corotated_stress). With n normal to the membrane, t = tr U and c = lambda (t - 2) - 2 mu: turns
// in the plane have the eigenvalue 2 (lambda + mu) (t - 2) / t, motion along n the matrix 2 mu I + c U^-1, all else is
// definite. Without area only 2 mu I is left, as there is no rotation.
template <class T>
inline StressDerivative<T> corotated_derivative(const T& lambda, const T& mu, const Columns<T>& f) {
  const T xx = dot(f.x, f.x), yy = dot(f.y, f.y), xy = dot(f.x, f.y);
  const Vector3<T> across = cross(f.x, f.y);
  const T s = sqrt(dot(across, across)), trace = sqrt((xx + yy) + (s + s));
  const auto has_area = s > T(1e-6f) * (xx + yy);
  const T inverse = select(has_area, T(1) / select(has_area, s, T(1)), T(0));
  const T by_trace = select(has_area, T(1) / select(has_area, trace, T(1)), T(0)), unit = inverse * by_trace;
  const T ixx = (yy + s) * unit, iyy = (xx + s) * unit, ixy = -(xy * unit);  // U^-1
  const Vector3<T> normal = inverse * across;
  const Columns<T> r = {ixx * f.x + ixy * f.y, ixy * f.x + iyy * f.y};
  const T twice = mu + mu, of_r = lambda * (trace - T(2)) - twice;
  const Symmetric2<T> along = positive_part<T>({twice + of_r * ixx, of_r * ixy, twice + of_r * iyy});
  const T turn = max((lambda + mu) * ((trace - T(2)) * by_trace), T(0)) - mu;
  const Block<T> rxx = outer(r.x, r.x), rxy = outer(r.x, r.y), ryy = outer(r.y, r.y), n = outer(normal, normal);
  return {on_diagonal(twice) + (lambda * rxx + (turn * ryy + (along.xx - twice) * n)),
          lambda * rxy + (along.xy * n + -(turn * transposed(rxy))),
          on_diagonal(twice) + (lambda * ryy + (turn * rxx + (along.yy - twice) * n))};
}

// Corners of a membrane and of a hinge, two and two, in the order in which their blocks are kept.
inline constexpr int membrane_pairs = 3, hinge_pairs = 6;
inline constexpr int membrane_pair[membrane_pairs][2] = {{0, 1}, {0, 2}, {1, 2}};
inline constexpr int hinge_pair[hinge_pairs][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};

template <class T, int count>
struct Blocks {
  Block<T> of[count];
};

template <class T>
inline Blocks<T, membrane_pairs> blocks_of_membrane(const Membrane<T>& m, const StressDerivative<T>& c) {
  const T second = m.area * m.y2;
  const Block<T> k11 = m.area *
                       ((m.x1 * m.x1) * c.xx + ((m.x1 * m.y1) * (c.xy + transposed(c.xy)) + (m.y1 * m.y1) * c.yy)),
                 k12 = second * (m.x1 * c.xy + m.y1 * c.yy), k22 = (second * m.y2) * c.yy;
  return {{-(k11 + transposed(k12)), -(k12 + k22), k12}};
}

// --- Hinges

template <class T>
inline Blocks<T, hinge_pairs> blocks_of_hinge(const Scales<T>& scales, const T& stiffness, const T& root_of_damping,
                                              const Fold<T>& fold) {
  const T cosine = sqrt(max(T(1) - fold.sine * fold.sine, T(0)));
  const T share = scales.square * ((stiffness * fold.shape) * (T(.5f) * cosine)) +
                  scales.step * (root_of_damping * root_of_damping);
  Blocks<T, hinge_pairs> k;
  for (int p = 0; p < hinge_pairs; ++p)
    k.of[p] = outer(share * fold.slope[hinge_pair[p][0]], fold.slope[hinge_pair[p][1]]);
  return k;
}

}  // namespace lockstep::production_cloth
