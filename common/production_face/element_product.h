// The product of one tetrahedron's stiffness and its corners' displacements, without the stiffness. For a number or for
// lanes.
//
// Displacements x_a change F by dF = sum over a = 1, 2, 3 of (x_a - x_0) gradient_a^T. With b_a = V^T gradient_a, in
// the frames of U and V,
//
//   dF' = U^T dF V = sum over a of U^T (x_a - x_0) b_a^T,   dP' = the derivative (flesh_material.h) of dF',
//   y_a = volume U dP' b_a,                                 y_0 = -(y_1 + y_2 + y_3).
//
// A fibre adds volume (w . gradient_a) ((t / l) dF w + c (F w) (F w . dF w)).
//
// Source: Teran, Sifakis, Irving and Fedkiw, Robust quasistatic finite elements and flesh simulation, SCA 2005.
#pragma once

#include "common/production_face/parts.h"
#include "common/production_face/strained_element.h"

namespace lockstep::production_face {

// x_a - x_0 of corners a = 1, 2 and 3.
template <class T>
struct Moved {
  Vector3<T> by[3];
};

// dP' of dF'.
template <class T>
LOCKSTEP_INLINE Matrix3<T> derivative_of(const StressDerivative<T>& d, const Matrix3<T>& f) {
  return {
      {d.xx * f.x.x + d.xy * f.y.y + d.zx * f.z.z, d.alpha.z * f.x.y + d.beta.z * f.y.x,
       d.alpha.y * f.x.z + d.beta.y * f.z.x},
      {d.alpha.z * f.y.x + d.beta.z * f.x.y, d.xy * f.x.x + d.yy * f.y.y + d.yz * f.z.z,
       d.alpha.x * f.y.z + d.beta.x * f.z.y},
      {d.alpha.y * f.z.x + d.beta.y * f.x.z, d.alpha.x * f.z.y + d.beta.x * f.y.z,
       d.zx * f.x.x + d.yz * f.y.y + d.zz * f.z.z},
  };
}

// The flesh's parts of corners 1, 2 and 3.
template <class T>
LOCKSTEP_INLINE void set_flesh_product(const StrainedElement<T>& e, const Moved<T>& moved, Parts<T>& y) {
  Vector3<T> b[3];
  for (int a = 0; a < 3; ++a) b[a] = transposed_times(e.v, e.gradient[a]);
  const Vector3<T> m[3] = {transposed_times(e.u, moved.by[0]), transposed_times(e.u, moved.by[1]),
                           transposed_times(e.u, moved.by[2])};
  const Matrix3<T> f = {b[0].x * m[0] + b[1].x * m[1] + b[2].x * m[2], b[0].y * m[0] + b[1].y * m[1] + b[2].y * m[2],
                        b[0].z * m[0] + b[1].z * m[1] + b[2].z * m[2]};
  const Matrix3<T> p = derivative_of(e.derivative, f);
  for (int a = 0; a < 3; ++a) y.of[a + 1] = e.volume * (e.u * (p * b[a]));
}

// Adds a fibre's to them.
template <class T>
LOCKSTEP_INLINE void add_fibre_product(const StrainedElement<T>& e, const StrainedFibre<T>& fibre,
                                       const Moved<T>& moved, Parts<T>& y) {
  T along[3];
  for (int a = 0; a < 3; ++a) along[a] = dot(fibre.direction, e.gradient[a]);
  const Vector3<T> turned = along[0] * moved.by[0] + along[1] * moved.by[1] + along[2] * moved.by[2];
  const Vector3<T> pull = fibre.per_stretch * turned + (fibre.stiffness * dot(fibre.along, turned)) * fibre.along;
  for (int a = 0; a < 3; ++a) y.of[a + 1] = y.of[a + 1] + (e.volume * along[a]) * pull;
}

}  // namespace lockstep::production_face
