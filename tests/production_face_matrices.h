// Matrices in double for the tests of the production face.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>

#include "common/production_face/flesh_material.h"
#include "common/production_face/svd.h"

namespace lockstep::production_face {

using Vector = Vector3<double>;
using Matrix = Matrix3<double>;
inline Matrix operator+(const Matrix& a, const Matrix& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Matrix operator*(double s, const Matrix& a) { return {s * a.x, s * a.y, s * a.z}; }
inline Matrix product(const Matrix& a, const Matrix& b) { return {a * b.x, a * b.y, a * b.z}; }
inline Matrix transposed(const Matrix& a) {
  return {{a.x.x, a.y.x, a.z.x}, {a.x.y, a.y.y, a.z.y}, {a.x.z, a.y.z, a.z.z}};
}
inline double inner(const Matrix& a, const Matrix& b) { return dot(a.x, b.x) + dot(a.y, b.y) + dot(a.z, b.z); }
inline double norm(const Matrix& a) { return std::sqrt(inner(a, a)); }

inline constexpr Matrix identity = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

inline Matrix random_matrix(std::mt19937& generator) {
  std::normal_distribution<double> normal;
  const auto vector = [&] { return Vector3<double>{normal(generator), normal(generator), normal(generator)}; };
  return {vector(), vector(), vector()};
}

inline Matrix outer(const Vector3<double>& a, const Vector3<double>& b) { return {b.x * a, b.y * a, b.z * a}; }

inline double determinant(const Matrix& f) { return dot(f.x, cross(f.y, f.z)); }
inline Matrix cofactors(const Matrix& f) { return {cross(f.y, f.z), cross(f.z, f.x), cross(f.x, f.y)}; }
inline Vector size_of(const Vector& v) { return {std::abs(v.x), std::abs(v.y), std::abs(v.z)}; }

inline double most(const Matrix& m) {
  double most = 0;
  for (const Vector& c : {m.x, m.y, m.z}) most = std::max({most, std::abs(c.x), std::abs(c.y), std::abs(c.z)});
  return most;
}

// The stress without singular values, for J >= crushed: psi's slope by F.
inline Matrix stress_of_flesh(const Flesh& flesh, const Matrix& f) {
  const double volume = determinant(f), j = std::pow(volume, -2. / 3), slope = -2. / 3 * j / volume;
  const Matrix square = product(transposed(f), f), cubed = product(f, square);
  const double i = inner(f, f), pairs = .5 * (i * i - inner(square, square));
  const double by_volume =
      slope * (flesh.m10 * i + 2 * flesh.m01 * j * pairs) + flesh.kappa * std::log(volume) / volume;
  return 2 * (flesh.m10 * j + flesh.m01 * j * j * i) * f + (-2 * flesh.m01 * j * j) * cubed + by_volume * cofactors(f);
}

// dP of dF, by a derivative in the frames of U and V.
inline Matrix applied(const StressDerivative<double>& a, const Matrix& u, const Matrix& v, const Matrix& df) {
  const Matrix g = product(transposed(u), product(df, v));
  const Matrix dp = {{a.xx * g.x.x + a.xy * g.y.y + a.zx * g.z.z, a.alpha.z * g.x.y + a.beta.z * g.y.x,
                      a.alpha.y * g.x.z + a.beta.y * g.z.x},
                     {a.alpha.z * g.y.x + a.beta.z * g.x.y, a.xy * g.x.x + a.yy * g.y.y + a.yz * g.z.z,
                      a.alpha.x * g.y.z + a.beta.x * g.z.y},
                     {a.alpha.y * g.z.x + a.beta.y * g.x.z, a.alpha.x * g.z.y + a.beta.x * g.y.z,
                      a.zx * g.x.x + a.yz * g.y.y + a.zz * g.z.z}};
  return product(product(u, dp), transposed(v));
}

}  // namespace lockstep::production_face
