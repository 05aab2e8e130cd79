// A contact as the solver sees it: conditions on the velocities of two bodies at each point, and the impulses that meet
// them.
//
// For a point with normal n, arms r_a and r_b from the centres of mass, and impulse (p_n, p_t, p_u) along the normal
// and two tangents t and u:
//
//   relative velocity   v = v_b + w_b x r_b - v_a - w_a x r_a
//   non-penetration     0 <= p_n, complementary to n . v + s / h >= 0 where the surfaces are s > 0 apart, so that they
//                       may just meet in a step h; and to n . v >= 0 where they touch
//   friction            |p_t| <= mu p_n, |p_u| <= mu p_n, against t . v = 0 and u . v = 0: the box around Coulomb's
//                       cone
//
// Together they are a linear complementarity problem in the impulses ([LRB08] "Rigid Body Simulation").
#pragma once

#include <cstdint>
#include <vector>

#include "common/rigid/manifold.h"
#include "common/rigid/world.h"

namespace lockstep::rigid {

// Inverse inertia along the world's axes: symmetric, rows (xx xy xz), (xy yy yz), (xz yz zz); 1 / (kg m^2).
template <class T>
struct Symmetric3 {
  T xx, xy, xz, yy, yz, zz;
};

template <class T>
inline Vector3<T> operator*(const Symmetric3<T>& m, const Vector3<T>& v) {
  return {m.xx * v.x + m.xy * v.y + m.xz * v.z, m.xy * v.x + m.yy * v.y + m.yz * v.z,
          m.xz * v.x + m.yz * v.y + m.zz * v.z};
}

// R diag(d) R^T.
template <class T>
inline Symmetric3<T> turned(const Matrix3<T>& r, const T& dx, const T& dy, const T& dz) {
  const Vector3<T> x = dx * r.x, y = dy * r.y, z = dz * r.z;
  return {x.x * r.x.x + y.x * r.y.x + z.x * r.z.x, x.x * r.x.y + y.x * r.y.y + z.x * r.z.y,
          x.x * r.x.z + y.x * r.y.z + z.x * r.z.z, x.y * r.x.y + y.y * r.y.y + z.y * r.z.y,
          x.y * r.x.z + y.y * r.y.z + z.y * r.z.z, x.z * r.x.z + y.z * r.y.z + z.z * r.z.z};
}

template <class T>
struct InverseMass {
  T mass;  // 1 / kg
  Symmetric3<T> inertia;
};

// One row of a point, along a direction: the effective mass, kg, and the impulse so far, N s.
template <class T>
struct Row {
  T mass, impulse;
};

template <class T>
struct ConstraintPoint {
  Vector3<T> arm_a, arm_b;  // m
  T separation;             // m, when the step begins
  T bounce;                 // m/s: the normal velocity to leave with, or 0
  T max_normal_impulse;     // N s: of all substeps; > 0 where the point was hit
  Row<T> normal, tangent, bitangent;
};

// One contact for T = Real. For T = floatv, sixteen contacts that share no body that moves.
template <class T>
struct ContactConstraint {
  Vector3<T> normal, tangent, bitangent;  // unit, from a to b; n = t x u
  T friction;
  InverseMass<T> a, b;
  ConstraintPoint<T> point[most_points];
};

}  // namespace lockstep::rigid
