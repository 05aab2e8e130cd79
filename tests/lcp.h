// Linear complementarity problems, solved exactly but for rounding: for tests to measure iterative solvers against.
//
//   w = M z + q,   w >= 0,   z >= 0,   w . z = 0
//
// Lemke's algorithm. An artificial variable z0, added to every row, makes all rows feasible; then one variable at a
// time enters the basis, always the complement of the one that has just left, until z0 leaves. Where rows tie for
// leaving, the lexicographic rule decides, as if q were moved by (e, e^2, e^3, ...) for a tiny e: then no basis comes
// twice, and the algorithm ends. It ends with a solution, or on a ray, along which nothing bounds the entering
// variable. Of a copositive M, as contacts with friction have, a ray means that q asks for what no z gives (of a
// positive semidefinite M it proves so).
//
// Source: Cottle, Pang, Stone, The Linear Complementarity Problem (1992), 4.4 and 4.9; for contacts Anitescu and Potra,
//         Formulating Dynamic
// Multi-rigid-body Contact Problems with Friction as Solvable Linear Complementarity Problems, Nonlinear Dynamics 14
// (1997).
#pragma once

// As in common/rigid/mass.cpp: functions of Eigen that two files share must be the same in both.
#ifndef EIGEN_DONT_VECTORIZE
#define EIGEN_DONT_VECTORIZE
#endif

#include <gtest/gtest.h>

#include <cmath>
#include <eigen3/Eigen/Dense>
#include <stdexcept>
#include <utility>
#include <vector>

namespace lockstep {

struct LcpSolution {
  bool found;            // false where the algorithm ended on a ray: z and w are then empty
  Eigen::VectorXd z, w;  // w is M z + q, so that its rounding shows
};

inline LcpSolution solve_lcp(const Eigen::MatrixXd& m, const Eigen::VectorXd& q) {
  using Tableau = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const int n = static_cast<int>(q.size());
  if (n == 0 || q.minCoeff() >= 0) return {true, Eigen::VectorXd::Zero(n), q};

  // Columns: w, which hold the inverse of the basis, then z, z0, and the values of the basis: w - M z - z0 = q.
  const int z0 = 2 * n, value = 2 * n + 1;
  Tableau t(n, 2 * n + 2);
  t << Tableau::Identity(n, n), -m, Tableau::Constant(n, 1, -1), q;
  std::vector<int> basis(n);
  for (int i = 0; i < n; ++i) basis[i] = i;

  // What exact arithmetic would have as zero or as a tie, after a few hundred pivots of numbers about 1.
  constexpr double noise = 1e-10;

  // Whether row j bounds the entering variable to less than row i does.
  const auto bounds_more = [&](int i, int j, int entering) {
    const double by_i = 1 / t(i, entering), by_j = 1 / t(j, entering);
    const auto difference = [&](int column) {
      const double of_i = t(i, column) * by_i, of_j = t(j, column) * by_j;
      return std::abs(of_i - of_j) > noise * (1 + std::abs(of_i)) ? of_i - of_j : 0;
    };
    if (const double d = difference(value); d != 0) return d > 0;
    if (basis[i] == z0 || basis[j] == z0) return basis[j] == z0;  // z0 may leave: a solution
    for (int k = 0; k < n; ++k)
      if (const double d = difference(k); d != 0) return d > 0;
    return false;
  };
  const auto pivot = [&](int row, int entering) {
    t.row(row) *= 1 / t(row, entering);
    for (int i = 0; i < n; ++i)
      if (const double factor = t(i, entering); i != row && factor != 0) t.row(i) -= factor * t.row(row);
    std::swap(basis[row], entering);
    return entering;  // now the variable that left
  };

  // First z0 enters, in the row that asks most of it: among equals the last, which leaves all others lexicographically
  // positive.
  int row = 0;
  for (int i = 1; i < n; ++i)
    if (q(i) <= q(row)) row = i;
  int left = pivot(row, z0);
  for (int pivots = 1; left != z0; ++pivots) {
    if (pivots > 100 * n) throw std::runtime_error("Lemke's algorithm goes round: rounding spoilt the ties");
    const int entering = left < n ? left + n : left - n;
    const double largest = t.col(entering).cwiseAbs().maxCoeff();
    row = -1;
    for (int i = 0; i < n; ++i)
      if (t(i, entering) > noise * largest && (row < 0 || bounds_more(row, i, entering))) row = i;
    if (row < 0) return {false, {}, {}};
    left = pivot(row, entering);
  }

  // The basis anew, from M and q: without the rounding of all pivots.
  Eigen::MatrixXd columns(n, n);
  for (int i = 0; i < n; ++i)
    columns.col(i) = basis[i] < n ? Eigen::VectorXd(Eigen::VectorXd::Unit(n, basis[i])) : -m.col(basis[i] - n);
  const Eigen::VectorXd values = columns.partialPivLu().solve(q);
  LcpSolution solution{true, Eigen::VectorXd::Zero(n), q};
  for (int i = 0; i < n; ++i)
    if (basis[i] >= n) solution.z(basis[i] - n) = values(i);
  solution.w = m * solution.z + q;
  return solution;
}

// The most by which a number that should be zero may be negative: ties count as ties to within 1e-10.
inline double noise_of(const LcpSolution& s) {
  return 1e-10 * (1 + s.z.cwiseAbs().maxCoeff() + s.w.cwiseAbs().maxCoeff());
}

inline void expect_complementary(const LcpSolution& s) {
  ASSERT_TRUE(s.found);
  EXPECT_GE(s.z.minCoeff(), -noise_of(s));
  EXPECT_GE(s.w.minCoeff(), -noise_of(s));
  EXPECT_LE(s.z.cwiseMin(s.w).maxCoeff(), noise_of(s));
}

}  // namespace lockstep
