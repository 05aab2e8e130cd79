// Lemke's algorithm (tests/lcp.h) against closed forms and against all complementary bases.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

#include "tests/lcp.h"

namespace lockstep {
namespace {

using Eigen::MatrixXd, Eigen::VectorXd;

constexpr double u = std::numeric_limits<double>::epsilon() / 2;

TEST(Lcp, InOneDimension) {
  const auto solve = [](double m, double q) {
    return solve_lcp(MatrixXd::Constant(1, 1, m), VectorXd::Constant(1, q));
  };
  EXPECT_DOUBLE_EQ(solve(2, -3).z(0), 1.5);
  EXPECT_EQ(solve(2, 3).z(0), 0);
  EXPECT_EQ(solve(2, 3).w(0), 3);
  EXPECT_TRUE(solve(0, 0).found);
  EXPECT_FALSE(solve(0, -1).found);
  EXPECT_FALSE(solve(-1, -1).found);
}

TEST(Lcp, WithoutSolutionIsReported) {
  // Two rows push the same body in opposite directions: w0 = z0 - z1 - 1 and w1 = z1 - z0 - 1 would add up to -2.
  const MatrixXd m{{1, -1}, {-1, 1}};
  EXPECT_FALSE(solve_lcp(m, VectorXd::Constant(2, -1)).found);
  EXPECT_TRUE(solve_lcp(m, VectorXd{{-1, 1}}).found);  // w = 0 0 at z = 1 0
}

// A string from 0 to 1 under a load f hangs above a floor c below its ends. It lies on the floor between x and 1 - x,
// where f x^2 / 2 = c, and is a parabola on either side. Second differences of a parabola are exact, so the nodes have
// the values of the curve.
TEST(Lcp, StringAboveAFloor) {
  constexpr int nodes = 99, first_down = 30;  // node i at (i + 1) h
  constexpr double h = .01, f = 8, x = first_down * h, c = f * x * x / 2;
  MatrixXd m = MatrixXd::Zero(nodes, nodes);
  for (int i = 0; i < nodes; ++i) {
    m(i, i) = 2 / (h * h);
    if (i > 0) m(i, i - 1) = m(i - 1, i) = -1 / (h * h);
  }
  // z is the height above the floor: M (z - c) + f >= 0. The ends, at height c, belong to the first and the last row.
  VectorXd q = VectorXd::Constant(nodes, f);
  q(0) -= c / (h * h), q(nodes - 1) -= c / (h * h);
  const LcpSolution s = solve_lcp(m, q);
  expect_complementary(s);
  for (int i = 0; i < nodes; ++i) {
    const double side = std::min((i + 1) * h, 1 - (i + 1) * h);
    const double height = side < x ? f * (x - side) * (x - side) / 2 : 0;
    // q is rounded by 4 / h^2 c u. The inverse of M, of norm 1 / pi^2 (its lowest mode), magnifies this, once for each
    // node.
    EXPECT_NEAR(s.z(i), height, nodes * 4 / (h * h) * c * u) << i;
  }
}

// The test tries all complementary bases: for a P-matrix exactly one gives a solution, for every q [Cottle, Pang,
// Stone, 3.3.7].
TEST(Lcp, OfPMatricesAgainstAllBases) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int problem = 0; problem < 200; ++problem) {
    const int n = 1 + problem % 7;
    const auto any = [&] { return unit(random); };
    const MatrixXd a = MatrixXd::NullaryExpr(n, n, any), skew = MatrixXd::NullaryExpr(n, n, any);
    // Positive definite, unsymmetric.
    const MatrixXd m = a * a.transpose() + .1 * MatrixXd::Identity(n, n) + (skew - skew.transpose());
    VectorXd q = VectorXd::NullaryExpr(n, any);
    if (problem % 3 == 0) q.setConstant(-1);  // ties
    VectorXd expected;
    for (int basis = 0; basis < 1 << n; ++basis) {
      MatrixXd columns(n, n);
      for (int i = 0; i < n; ++i) columns.col(i) = basis >> i & 1 ? -m.col(i) : VectorXd(VectorXd::Unit(n, i));
      const VectorXd values = columns.partialPivLu().solve(q);
      if (values.minCoeff() < 0) continue;
      expected = VectorXd::Zero(n);
      for (int i = 0; i < n; ++i)
        if (basis >> i & 1) expected(i) = values(i);
    }
    ASSERT_EQ(expected.size(), n);
    const LcpSolution s = solve_lcp(m, q);
    expect_complementary(s);
    // Both solve the same basis by the same factorisation, with columns in different orders. The lowest eigenvalue of M
    // is at least .1, and its norm is 3 n.
    EXPECT_LE((s.z - expected).norm(), n * n * u * (3 * n / .1) * expected.norm() + u) << problem;
  }
}

}  // namespace
}  // namespace lockstep
