// Matrices in double for the tests of the production face.
#pragma once

#include <cmath>
#include <random>

#include "common/production_face/flesh_material.h"
#include "common/production_face/svd.h"

namespace lockstep::production_face {

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
