// The forces of links, membranes and hinges, elastic and of damping. Of a number or of lanes.
//
// Damping is linear in velocities, f = -D v, D symmetric and positive semidefinite, and 0 where velocities are those of
// a rigid motion.
#pragma once

#include "common/math.h"
#include "common/vector3.h"

namespace lockstep::production_cloth {

// --- Springs

template <class T>
struct Pull {
  Vector3<T> force;  // N, on the vertex from which the other is seen
  Vector3<T> along;  // the direction to the other, times the root of the damping
};

// d, m: from the vertex to the other. Two vertices at one place have no direction, and do not pull.
template <class T>
inline Pull<T> pull_of_spring(const T& rest_length, const T& stiffness, const T& root_of_damping, const Vector3<T>& d) {
  const T length = sqrt(dot(d, d));
  const Vector3<T> direction = (T(1) / max(length, T(1e-15f))) * d;
  return {(stiffness * (length - rest_length)) * direction, root_of_damping * direction};
}

// d, m/s: the other vertex's velocity less one's own.
template <class T>
inline Vector3<T> damping_of_spring(const Vector3<T>& along, const Vector3<T>& d) {
  return dot(along, d) * along;
}

// --- Membranes

// Of Dm^-1, where the first side at rest is the x axis: rows (x1, y1) and (0, y2), 1/m; and the area, m^2.
template <class T>
struct Membrane {
  T x1, y1, y2, area;
};

// A 3x2 matrix, by columns.
template <class T>
struct Columns {
  Vector3<T> x, y;
};

// F, of the sides from corner 0 to corners 1 and 2; or its rate, of their velocities.
template <class T>
inline Columns<T> deformation_of(const Membrane<T>& m, const Vector3<T>& first, const Vector3<T>& second) {
  return {m.x1 * first, m.y1 * first + m.y2 * second};
}

// F S, S = lambda tr(E) I + 2 mu E.
template <class T>
inline Columns<T> stress_of(const T& lambda, const T& mu, const Columns<T>& f, const T& exx, const T& eyy,
                            const T& exy) {
  const T pressure = lambda * (exx + eyy), twice = mu + mu;
  const T sxx = pressure + twice * exx, syy = pressure + twice * eyy, sxy = twice * exy;
  return {sxx * f.x + sxy * f.y, sxy * f.x + syy * f.y};
}

// St. Venant and Kirchhoff's P: E = (F^T F - I) / 2.
template <class T>
inline Columns<T> stvk_stress(const T& lambda, const T& mu, const Columns<T>& f) {
  const T half(.5f);
  return stress_of(lambda, mu, f, half * (dot(f.x, f.x) - T(1)), half * (dot(f.y, f.y) - T(1)), half * dot(f.x, f.y));
}

// P = 2 mu (F - R) + lambda (tr U - 2) R, F = R U. The root of the 2x2 F^T F is (F^T F + s I) / t, with s = det U = the
// length of the columns' cross product and t = tr U; and R = F (F^T F + s I)^-1 t = F (tr(U) I - U) / s. Where s is
// less than a millionth of |F|^2, which is a membrane without area, R counts as 0: there is no rotation.
template <class T>
inline Columns<T> corotated_stress(const T& lambda, const T& mu, const Columns<T>& f) {
  const T xx = dot(f.x, f.x), yy = dot(f.y, f.y), xy = dot(f.x, f.y);
  const Vector3<T> normal = cross(f.x, f.y);
  const T s = sqrt(dot(normal, normal)), trace = sqrt((xx + yy) + (s + s));
  const auto has_area = s > T(1e-6f) * (xx + yy);
  const T unit = select(has_area, T(1) / (select(has_area, s, T(1)) * select(has_area, trace, T(1))), T(0));
  // (tr(U) I - U) / s = adj(U) / s, of U = (F^T F + s I) / t.
  const T ixx = (yy + s) * unit, iyy = (xx + s) * unit, ixy = -(xy * unit);
  const Columns<T> r = {ixx * f.x + ixy * f.y, ixy * f.x + iyy * f.y};
  const T twice = mu + mu, of_r = lambda * (trace - T(2)) - twice;
  return {twice * f.x + of_r * r.x, twice * f.y + of_r * r.y};
}

// F C[rate of E], C[E] = lambda tr(E) I + 2 mu E: the rate of E is that of F^T F / 2, so that rotations give none.
template <class T>
inline Columns<T> damping_stress(const T& lambda, const T& mu, const Columns<T>& f, const Columns<T>& rate) {
  return stress_of(lambda, mu, f, dot(f.x, rate.x), dot(f.y, rate.y), T(.5f) * (dot(f.x, rate.y) + dot(f.y, rate.x)));
}

template <class T, int corners>
struct Parts {
  Vector3<T> of[corners];
};

// The forces on the corners: the columns of -A P Dm^-T, and minus their sum.
template <class T>
inline Parts<T, 3> parts_of_membrane(const Membrane<T>& m, const Columns<T>& p) {
  const Vector3<T> first = -m.area * (m.x1 * p.x + m.y1 * p.y), second = -m.area * (m.y2 * p.y);
  return {{-(first + second), first, second}};
}

// --- Hinges; corners as Topology has them

// sin(theta / 2), of the triangles' normals; its sign is that of (n1 x n2) . e. It is half the distance of the two
// normals: sqrt((1 - n1 . n2) / 2) would be off by 2e-4 near 0. From the other side, where n1 and n2 change places and
// e turns round, it has the same bits.
template <class T>
inline T sine_of_fold(const Vector3<T>& n1, const Vector3<T>& n2, const Vector3<T>& e) {
  const Vector3<T> apart = n1 - n2;
  const T half = T(.5f) * sqrt(dot(apart, apart));
  return select(dot(cross(n1, n2), e) < T(0), -half, half);
}

// sin(theta / 2); how stiff the hinge is at this shape, |e|^2 / (|N1| + |N2|); and the slope of minus theta by the
// corners, 1/m. All are 0 where a triangle has no area.
template <class T>
struct Fold {
  T sine, shape;
  Vector3<T> slope[4];
};

template <class T>
inline Fold<T> fold_of(const Vector3<T>& x0, const Vector3<T>& x1, const Vector3<T>& x2, const Vector3<T>& x3) {
  const Vector3<T> e = x3 - x2, from02 = x0 - x2, from03 = x0 - x3, from12 = x1 - x2, from13 = x1 - x3;
  const Vector3<T> normal1 = cross(from02, from03), normal2 = cross(from13, from12);
  const T square1 = dot(normal1, normal1), square2 = dot(normal2, normal2), square = dot(e, e);
  const auto is_there = (square1 > T(0)) & (square2 > T(0)) & (square > T(0));
  const T size1 = sqrt(select(is_there, square1, T(1))), size2 = sqrt(select(is_there, square2, T(1)));
  const T length = sqrt(select(is_there, square, T(1))), one = select(is_there, T(1), T(0));
  const Vector3<T> n1 = (one / size1) * normal1, n2 = (one / size2) * normal2;
  const Vector3<T> by1 = (T(1) / size1) * n1, by2 = (T(1) / size2) * n2, unit = (T(1) / length) * e;
  return {sine_of_fold(n1, n2, e),
          (one * square) / (size1 + size2),
          {length * by1, length * by2, dot(from03, unit) * by1 + dot(from13, unit) * by2,
           -(dot(from02, unit) * by1 + dot(from12, unit) * by2)}};
}

// --- Folding triangles: hinges, elastic and damping, triangle by triangle
//
// The slope of minus theta by a corner of one of the two triangles is a number times its triangle's normal n. Let
// w_c = n . v_c be the corners' velocities across their triangle, and a_c the cotangent of the angle at corner c. A
// triangle turns about its side opposite to corner 0 by a_2 (w_0 - w_1) + a_1 (w_0 - w_2), over the side's length; and
// likewise about the others. A hinge's rate is the sum of its triangles'. What it resists with acts on the corners by
// the same weights: the matrix of each triangle is symmetric, and its rows sum to 0.

template <class T>
struct Facet {
  Vector3<T> normal;  // n, of length 1; 0 without area
  T size;             // |N|, twice the area, m^2
  T at[3];            // a; 0 without area
};

// Of each side, which is opposite to the corner of the same number.
template <class T>
struct Sides {
  T of[3];
};

template <class T>
inline Facet<T> facet_of(const Vector3<T>& x0, const Vector3<T>& x1, const Vector3<T>& x2) {
  const Vector3<T> d01 = x1 - x0, d02 = x2 - x0, d12 = x2 - x1, normal = cross(d01, d02);
  const T square = dot(normal, normal);
  const auto has_area = square > T(0);
  const T size = sqrt(square), inverse = select(has_area, T(1), T(0)) / select(has_area, size, T(1));
  return {inverse * normal, size, {inverse * dot(d01, d02), -(inverse * dot(d01, d12)), inverse * dot(d02, d12)}};
}

// The weighted sums of the differences of three numbers, given as those of 0 and 1, 1 and 2, 2 and 0.
template <class T>
inline Sides<T> sums_of_differences(const T (&at)[3], const T& d01, const T& d12, const T& d20) {
  const T a = at[0] * d12, b = at[1] * d20, c = at[2] * d01;
  return {{c - b, a - c, b - a}};
}

// How fast a triangle turns about its sides, times their lengths. One velocity that all corners have is no rate.
template <class T>
inline Sides<T> rates_of_facet(const Vector3<T>& normal, const T (&at)[3], const Vector3<T>& v0, const Vector3<T>& v1,
                               const Vector3<T>& v2) {
  const T w1 = dot(normal, v1 - v0), w2 = dot(normal, v2 - v0);
  return sums_of_differences(at, -w1, w1 - w2, w2);
}

// What a hinge resists with, over its length: to being bent, N; and how much to a rate times the length, kg/s: its
// damping over |e|^2. Both are 0 where a triangle has no area. They have the same bits from either side.
template <class T>
struct Resistance {
  T torque, of_rate;
};

template <class T>
inline Resistance<T> resistance_of_hinge(const T& stiffness, const T& rest_sine, const T& root_of_damping,
                                         const Vector3<T>& n1, const T& size1, const Vector3<T>& n2, const T& size2,
                                         const Vector3<T>& e) {
  const T square = dot(e, e), none(0), one(1);
  const auto is_there = (size1 > none) & (size2 > none) & (square > none);
  const T shape = sqrt(square) / select(is_there, size1 + size2, one);
  return {select(is_there, (stiffness * shape) * (rest_sine - sine_of_fold(n1, n2, e)), none),
          select(is_there, root_of_damping * root_of_damping, none) / select(is_there, square, one)};
}

// The forces on the corners are these numbers times the facet's normal. torque: what the sides' hinges resist with,
// over the sides' lengths.
template <class T>
inline Sides<T> pushes_of_facet(const T (&at)[3], const Sides<T>& torque) {
  const T(&t)[3] = torque.of;
  return sums_of_differences(at, t[1] - t[0], t[2] - t[1], t[0] - t[2]);
}

}  // namespace lockstep::production_cloth
