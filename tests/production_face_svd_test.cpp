// Singular values and definite derivatives against Eigen's in double.
#include <gtest/gtest.h>
#ifndef EIGEN_DONT_VECTORIZE
#define EIGEN_DONT_VECTORIZE
#endif
#include <cstdio>
#include <eigen3/Eigen/Dense>
#include <functional>
#include <string>
#include <vector>

#include "common/production_face/element.h"
#include "tests/production_face_matrices.h"

namespace lockstep::production_face {
namespace {

using Eigen::Matrix3d;

Matrix3d to_eigen(const Matrix& m) {
  Matrix3d e;
  e << m.x.x, m.y.x, m.z.x, m.x.y, m.y.y, m.z.y, m.x.z, m.y.z, m.z.z;
  return e;
}

template <class From>
Matrix to_double(const Matrix3<From>& m) {
  return {{m.x.x, m.x.y, m.x.z}, {m.y.x, m.y.y, m.y.z}, {m.z.x, m.z.y, m.z.z}};
}

Matrix3<float> to_float(const Matrix& m) {
  const auto vector = [](const Vector3<double>& v) { return Vector3<float>{float(v.x), float(v.y), float(v.z)}; };
  return {vector(m.x), vector(m.y), vector(m.z)};
}

// A matrix with these singular values; a negative one turns it inside out.
Matrix with_values(double x, double y, double z, std::mt19937& generator) {
  const auto turn = [&] { return svd(random_matrix(generator)).u; };
  const Matrix u = turn(), v = turn();
  return product({x * u.x, y * u.y, z * u.z}, transposed(v));
}

struct Class {
  std::string name;
  double error;  // that svd.h claims, of the greatest entry
  std::function<Matrix(std::mt19937&)> make;
};

const std::vector<Class> classes = {
    {"flesh", 1e-6, [](std::mt19937& g) { return product(svd(random_matrix(g)).u, identity + .1 * random_matrix(g)); }},
    {"normal", 1e-6, [](std::mt19937& g) { return random_matrix(g); }},
    {"equal", 1e-6, [](std::mt19937& g) { return with_values(1.3, 1, 1, g); }},
    {"all equal", 1e-6, [](std::mt19937& g) { return with_values(1, 1, -1, g); }},
    {"flat", 1e-6, [](std::mt19937& g) { return with_values(1, .5, 0, g); }},
    {"a line", 1e-6, [](std::mt19937& g) { return with_values(1, 0, 0, g); }},
    {"graded", 1e-5, [](std::mt19937& g) { return with_values(1, 1e-2, -1e-4, g); }}};

double most(const Matrix3d& m) { return m.cwiseAbs().maxCoeff(); }

struct Errors {
  double reconstruction = 0, values = 0, orthogonality = 0;
};

template <class Real>
Errors errors_of(const Matrix3<Real>& f) {
  const Svd<Real> found = svd(f);
  const Matrix3d truth = to_eigen(to_double(f)), u = to_eigen(to_double(found.u)), v = to_eigen(to_double(found.v));
  const Eigen::Vector3d s(found.s.x, found.s.y, found.s.z);
  EXPECT_GE(found.s.x, 0);
  EXPECT_GE(found.s.y, 0);
  EXPECT_GT(u.determinant(), .99);
  EXPECT_GT(v.determinant(), .99);
  const Eigen::Vector3d values = Eigen::JacobiSVD<Matrix3d>(truth).singularValues();
  return {most(u * s.asDiagonal() * v.transpose() - truth) / most(truth),
          (s.cwiseAbs() - values).cwiseAbs().maxCoeff() / most(truth),
          std::max(most(u * u.transpose() - Matrix3d::Identity()), most(v * v.transpose() - Matrix3d::Identity()))};
}

// The worst of 20,000 matrices of each class: what the header claims. Singular values are off by no more than F is,
// in the 2-norm, which is at most three times the greatest entry.
TEST(ProductionFaceSvd, ErrorsAreThoseClaimed) {
  for (const Class& c : classes) {
    std::mt19937 generator(1);
    Errors worst;
    for (int i = 0; i < 20000; ++i) {
      const Errors e = errors_of(to_float(c.make(generator)));
      worst.reconstruction = std::max(worst.reconstruction, e.reconstruction);
      worst.values = std::max(worst.values, e.values);
      worst.orthogonality = std::max(worst.orthogonality, e.orthogonality);
    }
    std::printf("%-10s F %.1e, s %.1e, U and V %.1e\n", c.name.c_str(), worst.reconstruction, worst.values,
                worst.orthogonality);
    EXPECT_LE(worst.reconstruction, c.error) << c.name;
    EXPECT_LE(worst.values, 3 * c.error) << c.name;
    EXPECT_LE(worst.orthogonality, 1.2e-6) << c.name;
  }
}

// In double, u is 2^-29 of what it is in float.
TEST(ProductionFaceSvd, ErrorsInDoubleAreOfDouble) {
  for (const Class& c : classes) {
    std::mt19937 generator(2);
    double worst = 0;
    for (int i = 0; i < 5000; ++i) worst = std::max(worst, errors_of(c.make(generator)).reconstruction);
    std::printf("%-10s F %.1e\n", c.name.c_str(), worst);
    EXPECT_LE(worst, c.error * 0x1p-29) << c.name;
  }
}

TEST(ProductionFaceSvd, ValuesAreSortedAndSigned) {
  std::mt19937 generator(3);
  for (int i = 0; i < 2000; ++i) {
    const Matrix3<float> f = to_float(random_matrix(generator));
    const Vector3<float> s = svd(f).s;
    EXPECT_GE(s.x, s.y * (1 - 1e-6f));
    EXPECT_GE(s.y, std::abs(s.z) * (1 - 1e-6f));
    EXPECT_EQ(s.z < 0, to_eigen(to_double(f)).determinant() < 0);
  }
}

TEST(ProductionFaceSvd, SpecialMatrices) {
  const auto expect = [](const Matrix3<float>& f, const Vector3<float>& expected) {
    const Svd<float> found = svd(f);
    EXPECT_EQ(found.s.x, expected.x);
    EXPECT_EQ(found.s.y, expected.y);
    EXPECT_EQ(found.s.z, expected.z);
  };
  expect({{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {1, 1, 1});
  expect({{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}, {0, 0, 0});
  expect({{1, 0, 0}, {0, 2, 0}, {0, 0, 3}}, {3, 2, 1});
  expect({{1, 0, 0}, {0, -1, 0}, {0, 0, 1}}, {1, 1, -1});
}

// Small numbers, whose squares are denormal or nothing, and large ones.
TEST(ProductionFaceSvd, IsFiniteAtAnySize) {
  std::mt19937 generator(4);
  for (const double size : {1e-38, 1e-30, 1e-20, 1e-12, 1e-9, 1e-3, 1e4, 1e9})
    for (int i = 0; i < 500; ++i) {
      const Matrix any = random_matrix(generator), f = size / most(to_eigen(any)) * any;
      const Svd<float> found = svd(to_float(f));
      const Matrix3d u = to_eigen(to_double(found.u)), v = to_eigen(to_double(found.v));
      const Eigen::Vector3d s(found.s.x, found.s.y, found.s.z);
      EXPECT_TRUE(u.allFinite() && v.allFinite() && s.allFinite());
      EXPECT_LE(most(u * s.asDiagonal() * v.transpose() - to_eigen(f)), 1e-9 + 1e-6 * most(to_eigen(f)));
    }
}

// --- Definite derivatives

StressDerivative<double> to_double(const StressDerivative<float>& d) {
  return {d.xx, d.yy, d.zz, d.xy, d.yz, d.zx, {d.alpha.x, d.alpha.y, d.alpha.z}, {d.beta.x, d.beta.y, d.beta.z}};
}

Matrix3d block_of(const StressDerivative<double>& d) {
  Matrix3d m;
  m << d.xx, d.xy, d.zx, d.xy, d.yy, d.yz, d.zx, d.yz, d.zz;
  return m;
}

Matrix3d clamped(const Matrix3d& m) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(m);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).asDiagonal() * eigen.eigenvectors().transpose();
}

// Any derivative of that size, the block moved by `more` towards one that is definite.
StressDerivative<float> random_derivative(double size, double more, std::mt19937& generator) {
  const Matrix m = size * random_matrix(generator), pairs = size * random_matrix(generator);
  const auto f = [](double x) { return static_cast<float>(x); };
  return {f(m.x.x + more * size),
          f(m.y.y + more * size),
          f(m.z.z + more * size),
          f(m.x.y),
          f(m.y.z),
          f(m.z.x),
          {f(pairs.x.x), f(pairs.x.y), f(pairs.x.z)},
          {f(pairs.y.x), f(pairs.y.y), f(pairs.y.z)}};
}

StressDerivative<float> made_definite(StressDerivative<float> d) {
  make_pairs_definite(d);
  const ScaledBlock<float> scaled = scaled_block(d);
  if (is_definite(scaled)) return d;
  const auto [xx, yy, zz, xy, zx, yz] = definite_block(scaled);
  return {xx, yy, zz, xy, yz, zx, d.alpha, d.beta};
}

// The block's eigenvalues are those of it but for rounding, and a clamp moves no farther (it is a projection to a
// convex set). The axes are a rotation to 1e-6, twice; the iteration's eighteen turns round each entry by at most 4 u
// of the block, u = 2^-24, the product that is made of them by as much again: (2.4e-6 + 76 u) |block|.
TEST(ProductionFaceDefinite, IsAnEigenvalueClamp) {
  std::mt19937 generator(5);
  int kept = 0, changed = 0;
  for (int i = 0; i < 6000; ++i) {
    const double sizes[] = {1, 1e6, 1e30};
    const StressDerivative<float> a = random_derivative(sizes[i % 3], i % 7 - 2, generator), d = made_definite(a);
    const Matrix3d block = block_of(to_double(a)), found = block_of(to_double(d));
    const double least = Eigen::SelfAdjointEigenSolver<Matrix3d>(block).eigenvalues()[0];
    EXPECT_LE((found - clamped(block)).norm(), (2.4e-6 + 76 * 0x1p-24) * block.norm());
    if (least > 1e-3 * block.norm()) {  // beyond the minors' margin, 1e-5 of a product of three
      EXPECT_EQ(found, block);
      ++kept;
    } else {
      ++changed;
    }
    const auto pair = [](float alpha, float beta, float new_alpha, float new_beta) {
      if (alpha >= std::abs(beta)) {
        EXPECT_EQ(new_alpha, alpha);
        EXPECT_EQ(new_beta, beta);
        return;
      }
      EXPECT_GE(new_alpha, std::abs(new_beta));
      const double sum = std::max(double(alpha) + beta, 0.), difference = std::max(double(alpha) - beta, 0.);
      EXPECT_NEAR(new_alpha, .5 * (sum + difference), 0x1p-24 * new_alpha);
      EXPECT_NEAR(new_beta, .5 * (sum - difference), 0x1p-24 * new_alpha);
    };
    pair(a.alpha.x, a.beta.x, d.alpha.x, d.beta.x);
    pair(a.alpha.y, a.beta.y, d.alpha.y, d.beta.y);
    pair(a.alpha.z, a.beta.z, d.alpha.z, d.beta.z);
  }
  EXPECT_GT(kept, 500);
  EXPECT_GT(changed, 500);
}

// A block on the border: two or three of its rows are one. What passes the minors is definite.
TEST(ProductionFaceDefinite, RoundingPassesNothingIndefinite) {
  std::mt19937 generator(6);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int i = 0; i < 20000; ++i) {
    const Vector3<double> v = random_matrix(generator).x, w = std::pow(10, -4 * (i % 3)) * random_matrix(generator).x;
    const Matrix m = outer(v, v) + outer(w, w) + std::pow(10, -1. - i % 8) * uniform(generator) * identity;
    const StressDerivative<float> a = {float(m.x.x), float(m.y.y), float(m.z.z), float(m.x.y),
                                       float(m.y.z), float(m.z.x), {1, 1, 1},    {0, 0, 0}};
    const Matrix3d block = block_of(to_double(a)), found = block_of(to_double(made_definite(a)));
    const double least = Eigen::SelfAdjointEigenSolver<Matrix3d>(found).eigenvalues()[0];
    // axes diag axes^T is definite whatever the axes are, but for the four roundings of each entry, 12 u in all; one
    // that is kept is definite.
    EXPECT_GE(least, found == block ? -1e-15 * block.norm() : -12 * 0x1p-24 * found.norm());
  }
}

TEST(ProductionFaceDefinite, NothingStaysNothing) {
  const StressDerivative<float> d = made_definite(StressDerivative<float>{});
  for (const float x : {d.xx, d.yy, d.zz, d.xy, d.yz, d.zx, d.alpha.x, d.beta.x}) EXPECT_EQ(x, 0);
}

}  // namespace
}  // namespace lockstep::production_face
