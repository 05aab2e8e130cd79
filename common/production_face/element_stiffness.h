// The stiffness of one tetrahedron, K = -df/du: 3x3 blocks K_ac = -df_a/du_c of its corners a and c. For a number or
// for lanes.
//
// A displacement e of corner c changes F by e gradient_c^T. With b_a = V^T gradient_a, in the frames of U and V,
//
//   K_ac = volume U M U^T,   M_ii = a_ii b_ai b_ci + sum over k != i of alpha_ik b_ak b_ck,
//                            M_ij = a_ij b_ai b_cj + beta_ij b_aj b_ci,
//
// with the derivative of flesh_material.h. A fibre adds
//
//   volume (w . gradient_a) (w . gradient_c) (t / l I + c (F w) (F w)^T).
//
// K_ca is K_ac^T, so a block for each two corners is enough. Where all corners move alike nothing changes: the blocks
// of a row sum to 0. So those of corner 0 follow from the others', and the diagonal of the whole matrix follows from
// its other blocks (set_diagonal): a tetrahedron gives none of it.
//
// Source: Teran, Sifakis, Irving and Fedkiw, Robust quasistatic finite elements and flesh simulation, SCA 2005.
#pragma once

#include "common/production_face/strained_element.h"

namespace lockstep::production_face {

inline constexpr int pairs = 6;  // of corners

// Where K_ac stands, or its transpose where a > c: the pairs first, then the blocks of corners 1, 2 and 3 with
// themselves, from which those of corner 0 follow.
inline constexpr int block_of[4][4] = {{-1, 0, 1, 2}, {0, 6, 3, 4}, {1, 3, 7, 5}, {2, 4, 5, 8}};

template <class T>
struct ElementStiffness {
  T block[pairs + 3][9];  // row by row

  // K_ac, row r and column s.
  const T& at(int a, int c, int r, int s) const { return block[block_of[a][c]][a <= c ? 3 * r + s : 3 * s + r]; }
};

namespace stiffness_detail {

// M of corners a and c; `d` is the derivative times the volume. M is symmetric where a is c.
template <class T>
inline Matrix3<T> in_frames(const StressDerivative<T>& d, const Vector3<T>& a, const Vector3<T>& c) {
  const Vector3<T> same = {a.x * c.x, a.y * c.y, a.z * c.z};
  return {{d.xx * same.x + d.alpha.z * same.y + d.alpha.y * same.z, d.xy * (a.y * c.x) + d.beta.z * (a.x * c.y),
           d.zx * (a.z * c.x) + d.beta.y * (a.x * c.z)},
          {d.xy * (a.x * c.y) + d.beta.z * (a.y * c.x), d.yy * same.y + d.alpha.z * same.x + d.alpha.x * same.z,
           d.yz * (a.z * c.y) + d.beta.x * (a.y * c.z)},
          {d.zx * (a.x * c.z) + d.beta.y * (a.z * c.x), d.yz * (a.y * c.z) + d.beta.x * (a.z * c.y),
           d.zz * same.z + d.alpha.y * same.x + d.alpha.x * same.y}};
}

// Row by row: the columns of U M, each along one axis of U.
template <class T>
inline void turn(const Matrix3<T>& u, const Matrix3<T>& m, bool symmetric, T (&k)[9]) {
  const Vector3<T> x = u * m.x, y = u * m.y, z = u * m.z;
  const Vector3<T> row[3] = {{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}};
  const Vector3<T> column[3] = {{u.x.x, u.y.x, u.z.x}, {u.x.y, u.y.y, u.z.y}, {u.x.z, u.y.z, u.z.z}};
  for (int r = 0; r < 3; ++r)
    for (int s = 0; s < 3; ++s) k[3 * r + s] = symmetric && s < r ? k[3 * s + r] : dot(row[r], column[s]);
}

}  // namespace stiffness_detail

// The flesh's stiffness between corners 1, 2 and 3.
template <class T>
inline void set_flesh_stiffness(const StrainedElement<T>& e, ElementStiffness<T>& k) {
  const auto& [xx, yy, zz, xy, yz, zx, alpha, beta] = e.derivative;
  const T& v = e.volume;
  const StressDerivative<T> d = {v * xx, v * yy, v * zz, v * xy, v * yz, v * zx, v * alpha, v * beta};
  Vector3<T> b[3];
  for (int a = 0; a < 3; ++a) b[a] = transposed_times(e.v, e.gradient[a]);
  for (int a = 0; a < 3; ++a)
    for (int c = a; c < 3; ++c)
      stiffness_detail::turn(e.u, stiffness_detail::in_frames(d, b[a], b[c]), a == c,
                             k.block[block_of[a + 1][c + 1]]);
}

// Adds a fibre's to them.
template <class T>
inline void add_fibre_stiffness(const StrainedElement<T>& e, const StrainedFibre<T>& fibre, ElementStiffness<T>& k) {
  const Vector3<T>& f = fibre.along;
  const Vector3<T> cf = fibre.stiffness * f;
  const T one = fibre.per_stretch;
  const T pull[9] = {one + cf.x * f.x, cf.x * f.y, cf.x * f.z, cf.x * f.y,      one + cf.y * f.y,
                     cf.y * f.z,       cf.x * f.z, cf.y * f.z, one + cf.z * f.z};
  T along[3];
  for (int a = 0; a < 3; ++a) along[a] = dot(fibre.direction, e.gradient[a]);
  for (int a = 0; a < 3; ++a)
    for (int c = a; c < 3; ++c) {
      const T share = e.volume * (along[a] * along[c]);
      T(&block)[9] = k.block[block_of[a + 1][c + 1]];
      for (int i = 0; i < 9; ++i) block[i] = block[i] + share * pull[i];
    }
}

// The blocks of corner 0 with the others.
template <class T>
inline void set_first_corner(ElementStiffness<T>& k) {
  for (int c = 1; c < 4; ++c)
    for (int r = 0; r < 3; ++r)
      for (int s = 0; s < 3; ++s)
        k.block[block_of[0][c]][3 * r + s] = -(k.at(1, c, r, s) + k.at(2, c, r, s) + k.at(3, c, r, s));
}

// A diagonal block of the matrix, from the sums of those to its left and to its right in its row: minus both, with the
// upper triangle in both halves.
template <class T>
inline void set_diagonal(const T* left, const T* right, T (&k)[9]) {
  for (int r = 0; r < 3; ++r)
    for (int s = r; s < 3; ++s) k[3 * r + s] = k[3 * s + r] = -(left[3 * r + s] + right[3 * r + s]);
}

}  // namespace lockstep::production_face
