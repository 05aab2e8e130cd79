// One tetrahedron: its strain, stress and the stress's derivative. For a number or for lanes.
#pragma once

#include "common/production_face/flesh_material.h"
#include "common/production_face/muscle.h"
#include "common/production_face/svd.h"

namespace lockstep::production_face {

// F of displacements u of the corners and gradients of corners 1, 2 and 3 (body.h).
template <class T>
inline Matrix3<T> deformation(const Vector3<T> (&u)[4], const Vector3<T> (&gradient)[3]) {
  Matrix3<T> f = {{T(1), T(0), T(0)}, {T(0), T(1), T(0)}, {T(0), T(0), T(1)}};
  for (int a = 0; a < 3; ++a) {
    const Vector3<T> d = u[a + 1] - u[0];
    f.x = f.x + gradient[a].x * d, f.y = f.y + gradient[a].y * d, f.z = f.z + gradient[a].z * d;
  }
  return f;
}

// U diag(s) V^T.
template <class T>
inline Matrix3<T> composed(const Matrix3<T>& u, const Vector3<T>& s, const Matrix3<T>& v) {
  const Vector3<T> x = s.x * u.x, y = s.y * u.y, z = s.z * u.z;
  return {v.x.x * x + v.y.x * y + v.z.x * z, v.x.y * x + v.y.y * y + v.z.y * z, v.x.z * x + v.y.z * y + v.z.z * z};
}

// The nearest derivative without negative eigenvalues has 0 in place of those that are negative. Eigenvalues are those
// of the pairs, alpha + beta and alpha - beta, and of the block of the diagonal. A pair or block without negative ones
// keeps its bits.
// Source: Teran, Sifakis, Irving and Fedkiw (2005), section 5.

template <class T>
inline void make_pairs_definite(StressDerivative<T>& d) {
  const auto pair = [](T& alpha, T& beta) {
    const auto is_definite = abs(beta) <= alpha;
    const T half = T(.5f) * max(alpha + abs(beta), T(0));
    beta = select(is_definite, beta, select(beta < T(0), -half, half)), alpha = select(is_definite, alpha, half);
  };
  pair(d.alpha.x, d.beta.x), pair(d.alpha.y, d.beta.y), pair(d.alpha.z, d.beta.z);
}

// The block of the diagonal over its size: products of three of its numbers might overflow.
template <class T>
struct ScaledBlock {
  svd_detail::Symmetric<T> block;
  T size;
};

template <class T>
inline ScaledBlock<T> scaled_block(const StressDerivative<T>& d) {
  const T sum = abs(d.xx) + abs(d.yy) + abs(d.zz) + abs(d.xy) + abs(d.yz) + abs(d.zx);
  const T size = max(sum, T(1e-30f)), scale = T(1) / size;
  return {{scale * d.xx, scale * d.yy, scale * d.zz, scale * d.xy, scale * d.zx, scale * d.yz}, size};
}

// By its minors, with a margin above what rounding makes of them.
template <class T>
inline auto is_definite(const ScaledBlock<T>& scaled) {
  const auto& [xx, yy, zz, xy, zx, yz] = scaled.block;
  const T of_xy = xx * yy - xy * xy, whole = zz * of_xy - yz * (xx * yz - zx * xy) + zx * (xy * yz - zx * yy);
  const T margin(1e-5f);
  return (xx > T(0)) & (of_xy > margin * (xx * yy)) & (whole > margin * (xx * yy * zz));
}

// The block without its negative eigenvalues. Needed only where is_definite is false.
template <class T>
inline svd_detail::Symmetric<T> definite_block(ScaledBlock<T> scaled) {
  svd_detail::Symmetric<T>& block = scaled.block;
  const Matrix3<T> axes = matrix_of(svd_detail::diagonalize(block));
  const auto kept_of = [&](const T& eigenvalue) { return scaled.size * max(eigenvalue, T(0)); };
  const Matrix3<T> kept = composed(axes, {kept_of(block.xx), kept_of(block.yy), kept_of(block.zz)}, axes);
  return {kept.x.x, kept.y.y, kept.z.z, kept.x.y, kept.z.x, kept.y.z};
}

// What an element's strain makes of it; at first without its muscles.
template <class T>
struct Element {
  Svd<T> strain;
  Matrix3<T> stress;
  T energy;
  StressDerivative<T> derivative;
};

template <class T>
inline Element<T> element(const Matrix3<T>& f, const Flesh& flesh) {
  Element<T> e;
  e.strain = svd(f);
  const Vector3<T>& s = e.strain.s;
  const FleshSlopes<T> slopes = flesh_slopes(flesh, s);
  e.stress = composed(e.strain.u, principal_stress(slopes, s), e.strain.v);
  e.energy = slopes.energy;
  e.derivative = stress_derivative(slopes, s);
  return e;
}

// What the derivative of a fibre's stress is made of (muscle.h).
template <class T>
struct Pull {
  Vector3<T> along;  // F w
  T per_stretch, stiffness;
};

// Adds a fibre's stress and energy to the element. `activation` is a d; `most` is sigma, Pa, 0 where there is no fibre.
template <class T, class Mask>
inline Pull<T> add_pull(const Matrix3<T>& f, const Vector3<T>& w, const T& activation, const T& most,
                        const Mask& definite, Element<T>& e) {
  const Vector3<T> along = f * w;
  const Tension<T> t = tension(sqrt(dot(along, along)), most * activation, most, definite);
  const Vector3<T> force = t.per_stretch * along;
  e.stress = {e.stress.x + w.x * force, e.stress.y + w.y * force, e.stress.z + w.z * force};
  e.energy = e.energy + t.energy;
  return {along, t.per_stretch, t.along};
}

}  // namespace lockstep::production_face
