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

// The nearest derivative without negative eigenvalues: those of the block of the diagonal and of each pair,
// alpha + beta and alpha - beta, become 0. One that has none stays as it is.
//
// The block is divided by its size first: products of three of its numbers may overflow. It is definite if its minors
// are positive; their margin is above what rounding makes of them. Only where it is not are its eigenvalues sought.
// Source: Teran, Sifakis, Irving and Fedkiw (2005), section 5.
template <class T>
inline StressDerivative<T> made_definite(const StressDerivative<T>& a) {
  StressDerivative<T> d = a;
  const auto pair = [](T& alpha, T& beta) {
    const auto is_definite = abs(beta) <= alpha;
    const T half = T(.5f) * max(alpha + abs(beta), T(0));
    beta = select(is_definite, beta, select(beta < T(0), -half, half)), alpha = select(is_definite, alpha, half);
  };
  pair(d.alpha.x, d.beta.x), pair(d.alpha.y, d.beta.y), pair(d.alpha.z, d.beta.z);

  const T sum = abs(a.xx) + abs(a.yy) + abs(a.zz) + abs(a.xy) + abs(a.yz) + abs(a.zx);
  const T size = max(sum, T(1e-30f)), scale = T(1) / size;
  const T xx = scale * a.xx, yy = scale * a.yy, zz = scale * a.zz;
  const T xy = scale * a.xy, yz = scale * a.yz, zx = scale * a.zx;
  const T of_xy = xx * yy - xy * xy, whole = zz * of_xy - yz * (xx * yz - zx * xy) + zx * (xy * yz - zx * yy);
  const T margin(1e-5f);
  const auto is_definite = (xx > T(0)) & (of_xy > margin * (xx * yy)) & (whole > margin * (xx * yy * zz));
  if (all(is_definite)) return d;
  svd_detail::Symmetric<T> block = {xx, yy, zz, xy, zx, yz};
  const Matrix3<T> axes = matrix_of(svd_detail::diagonalize(block));
  const auto kept_of = [&](const T& eigenvalue) { return size * max(eigenvalue, T(0)); };
  const Matrix3<T> kept = composed(axes, {kept_of(block.xx), kept_of(block.yy), kept_of(block.zz)}, axes);
  d.xx = select(is_definite, a.xx, kept.x.x), d.yy = select(is_definite, a.yy, kept.y.y);
  d.zz = select(is_definite, a.zz, kept.z.z), d.xy = select(is_definite, a.xy, kept.x.y);
  d.yz = select(is_definite, a.yz, kept.y.z), d.zx = select(is_definite, a.zx, kept.z.x);
  return d;
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
inline Element<T> element(const Matrix3<T>& f, const Flesh& flesh, bool definite) {
  Element<T> e;
  e.strain = svd(f);
  const Vector3<T>& s = e.strain.s;
  const FleshSlopes<T> slopes = flesh_slopes(flesh, s);
  e.stress = composed(e.strain.u, principal_stress(slopes, s), e.strain.v);
  e.energy = slopes.energy;
  e.derivative = stress_derivative(slopes, s);
  if (definite) e.derivative = made_definite(e.derivative);
  return e;
}

// A fibre's pull: adds its stress and its energy, and says what its derivative is made of.
template <class T>
struct Pull {
  Vector3<T> along;  // F w
  T per_stretch, stiffness;
};

// `activation` is a d, `is_there` whether the tetrahedron has the fibre.
template <class T, class Mask>
inline Pull<T> add_pull(const Matrix3<T>& f, const Vector3<T>& w, const T& activation, const Mask& is_there,
                        const Mask& definite, Element<T>& e) {
  const T most = select(is_there, T(muscle_stress), T(0));
  const Vector3<T> along = f * w;
  const Tension<T> t = tension(sqrt(dot(along, along)), most * activation, most, definite);
  const Vector3<T> force = t.per_stretch * along;
  e.stress = {e.stress.x + w.x * force, e.stress.y + w.y * force, e.stress.z + w.z * force};
  e.energy = e.energy + t.energy;
  return {along, t.per_stretch, t.along};
}

}  // namespace lockstep::production_face
