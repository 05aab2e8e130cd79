// Levels, incomplete Cholesky and conjugate gradients: against what defines them, against direct solutions by CHOLMOD,
// and both versions against each other.
#include <cmath>

#include "common/linear/conjugate_gradients.h"
#include "common/linear/dot.h"
#include "common/linear/incomplete_cholesky.h"
#include "common/linear/make.h"
#include "common/linear/multiply.h"
#include "tests/linear_cholmod.h"
#include "tests/linear_matrices.h"

namespace lockstep::linear {
namespace {

template <class Real>
System<Real> serial_system(const Rows<Real>& a, const auto& precondition) {
  return {[&](std::span<const Real> x, std::span<Real> y) { return serial::multiply_and_dot(a, x, y); },
          [=](std::span<const Real> x, std::span<Real> y) {
            precondition(x, y);
            return serial::dot(x, std::span<const Real>(y));
          },
          [&](std::span<const Real> b, std::span<const Real> x) { return residual_norm(a, b, x); }};
}

// --- Levels

TEST(LinearLevels, ComeAfterWhatTheyWaitFor) {
  for (const Rows<float>& a :
       {make_poisson(12, .3), random_definite(500, 4, 1), tridiagonal(30), scalar_rows(make_elasticity(3))}) {
    const Levels levels = make_levels(a);
    const Rows<float> ordered = reordered(a, levels.order);
    EXPECT_EQ(levels.begin.back(), a.rows);
    for (int level = 0; level < levels.count(); ++level)
      for (int i = levels.begin[level]; i < levels.begin[level + 1]; ++i) {
        if (i > levels.begin[level]) {
          EXPECT_LT(levels.order[i - 1], levels.order[i]);  // as before, within a level
        }
        bool waits_for_the_level_before = level == 0;
        for (int k = ordered.begin[i]; k < ordered.begin[i + 1]; ++k) {
          const int j = ordered.column[k];
          EXPECT_TRUE(j == i || j < levels.begin[level] || j >= levels.begin[level + 1]);
          EXPECT_EQ(j < i, levels.order[j] < levels.order[i]);  // rows wait for the same rows as before
          waits_for_the_level_before |= level > 0 && j >= levels.begin[level - 1] && j < levels.begin[level];
        }
        EXPECT_TRUE(waits_for_the_level_before);
      }
  }
  EXPECT_EQ(make_levels(tridiagonal(30)).count(), 30);
  EXPECT_EQ(make_levels(make_poisson(12, 0)).count(), 34);
  EXPECT_EQ(make_levels(Rows<float>{}).count(), 0);
}

TEST(LinearLevels, ReorderingMovesEntries) {
  const Rows<float> a = random_definite(60, 3, 2);
  const Levels levels = make_levels(a);
  const Eigen::MatrixXd before = to_eigen(a), after = to_eigen(reordered(a, levels.order));
  for (int i = 0; i < a.rows; ++i)
    for (int j = 0; j < a.rows; ++j) EXPECT_EQ(after(i, j), before(levels.order[i], levels.order[j]));
}

// --- Incomplete Cholesky, in double

Eigen::MatrixXd product_of(const Factor<double>& f) {
  const Eigen::VectorXd e = to_eigen(f.inverse).cwiseInverse();
  const Eigen::MatrixXd lower = Eigen::MatrixXd(to_eigen(f.lower)) + Eigen::MatrixXd(e.asDiagonal());
  const Eigen::MatrixXd upper = Eigen::MatrixXd(to_eigen(f.upper)) + Eigen::MatrixXd(e.asDiagonal());
  EXPECT_EQ((lower - upper.transpose()).norm(), 0);
  return lower * e.cwiseInverse().asDiagonal() * upper;
}

TEST(LinearIncompleteCholesky, WithoutModificationAgreesWithTheMatrixWhereThatHasEntries) {
  for (const Rows<float>& a : {make_poisson(6, .3), random_definite(80, 5, 3), scalar_rows(make_elasticity(3))}) {
    const Eigen::MatrixXd m = product_of(serial::incomplete_cholesky(convert<double>(a), {.tau = 0, .sigma = 0}));
    const Eigen::MatrixXd dense = to_eigen(a);
    for (int i = 0; i < a.rows; ++i)
      for (int k = a.begin[i]; k < a.begin[i + 1]; ++k)
        EXPECT_NEAR(m(i, a.column[k]), dense(i, a.column[k]), 1e-13 * dense.diagonal().maxCoeff()) << i;
  }
}

TEST(LinearIncompleteCholesky, FullyModifiedKeepsTheSumsOfRows) {
  for (const Rows<float>& a : {make_poisson(7, .3), make_poisson(9, 0)}) {
    const Eigen::MatrixXd m = product_of(serial::incomplete_cholesky(convert<double>(a), {.tau = 1, .sigma = 0}));
    const Eigen::VectorXd ones = Eigen::VectorXd::Ones(a.rows);
    EXPECT_LT((m * ones - to_eigen(a) * ones).cwiseAbs().maxCoeff(), 1e-12);
  }
}

TEST(LinearIncompleteCholesky, OfATridiagonalMatrixIsExact) {
  const Rows<float> a = tridiagonal(50);
  const Factor<double> f = serial::incomplete_cholesky(convert<double>(a), {});
  EXPECT_LT((product_of(f) - Eigen::MatrixXd(to_eigen(a))).norm(), 1e-14);
  for (int i = 0; i < 50; ++i)
    EXPECT_NEAR(1 / f.inverse[i], (i + 2.) / (i + 1.), 1e-14);  // the quotients of its minors
}

TEST(LinearIncompleteCholesky, OfACompleteMatrixIsCholesky) {
  const Rows<float> a = random_definite(12, 400, 4);
  ASSERT_EQ(a.value.size(), 144u);  // every entry is there, so that none is dropped
  const Factor<double> f = serial::incomplete_cholesky(convert<double>(a), {});
  EXPECT_LT((product_of(f) - Eigen::MatrixXd(to_eigen(a))).norm(), 1e-13);
}

TEST(LinearIncompleteCholesky, TakesTheDiagonalWhereTooMuchWasSubtracted) {
  // [1 -1; -1 1] is singular: e_2 = 0.
  Rows<float> a = tridiagonal(2);
  a.value = {1, -1, -1, 1};
  EXPECT_EQ(serial::incomplete_cholesky(a, {.tau = 0, .sigma = .25}).inverse, (Array<float>{1, 1}));
  a.value = {1, -1, -1, 1.5f};
  EXPECT_EQ(serial::incomplete_cholesky(a, {.tau = 0, .sigma = .25}).inverse, (Array<float>{1, 2}));
  a.value = {4};
  a.rows = a.columns = 1, a.begin = {0, 1}, a.column = {0};
  EXPECT_EQ(serial::incomplete_cholesky(a, {}).inverse, (Array<float>{.25f}));
}

TEST(LinearIncompleteCholesky, SolvesWithItsProduct) {
  for (const Rows<float>& a : {make_poisson(6, .3), random_definite(80, 5, 5), tridiagonal(33)}) {
    const Factor<double> f = serial::incomplete_cholesky(convert<double>(a), {});
    const Array<double> r = random_vector<double>(a.rows, 6);
    Array<double> z(a.rows);
    serial::solve(f, r, z);
    const Eigen::VectorXd rest = product_of(f) * to_eigen(z) - to_eigen(r);
    EXPECT_LT(rest.cwiseAbs().maxCoeff(), 1e-12 * to_eigen(z).cwiseAbs().maxCoeff());
  }
}

TEST(LinearIncompleteCholesky, ByLevelsHasTheSerialBits) {
  for (const Rows<float>& natural :
       {make_poisson(20, .3), make_poisson(33, .25), random_definite(2000, 3, 7), tridiagonal(40),
        scalar_rows(make_elasticity(5)), random_definite(1, 0, 1), random_definite(500, 0, 1), Rows<float>{}}) {
    const Levels levels = make_levels(natural);
    const Rows<float> a = reordered(natural, levels.order);
    const Array<float> r = random_vector<float>(a.rows, 8);
    for (const double tau : {0., .97}) {
      const Factor<float> f = serial::incomplete_cholesky(a, {.tau = tau});
      Array<float> z(a.rows);
      serial::solve(f, r, z);
      at_each_thread_count([&] {
        const Factor<float> by_levels = openmp::incomplete_cholesky(a, levels, {.tau = tau});
        EXPECT_TRUE(same_bits(by_levels.inverse, f.inverse));
        EXPECT_TRUE(same_bits(by_levels.lower.value, f.lower.value));
        EXPECT_TRUE(same_bits(by_levels.upper.value, f.upper.value));
        Array<float> y(a.rows, 77);
        openmp::solve(slice(by_levels, levels), r, y);
        EXPECT_TRUE(same_bits(y, z));
      });
    }
  }
}

TEST(LinearIncompleteCholesky, OfAGridHasTheSameBitsInEitherOrder) {
  const Rows<float> natural = make_poisson(24, 0);
  const Levels levels = make_levels(natural);
  const Factor<float> f = serial::incomplete_cholesky(natural, {});
  const Factor<float> by_levels = openmp::incomplete_cholesky(reordered(natural, levels.order), levels, {});
  const Array<float> r = random_vector<float>(natural.rows, 9);
  Array<float> z(natural.rows), y(natural.rows);
  serial::solve(f, r, z);
  openmp::solve(slice(by_levels, levels), reordered(view(r), levels.order), y);
  EXPECT_TRUE(same_bits(y, reordered(view(z), levels.order)));
}

// --- Conjugate gradients

TEST(LinearConjugateGradients, NeedsOneIterationWithAnExactPreconditioner) {
  const Rows<float> a = tridiagonal(200);
  const Rows<double> truth = convert<double>(a);
  const Factor<double> f = serial::incomplete_cholesky(truth, {});
  const Array<double> b = random_vector<double>(200, 1);
  Array<double> x(200);
  const Solution s = serial::conjugate_gradients(
      serial_system<double>(truth, [&](std::span<const double> r, std::span<double> z) { serial::solve(f, r, z); }), b,
      x, {.tolerance = 1e-10});
  EXPECT_EQ(s.iterations, 1);
  EXPECT_LT(s.true_residual, 1e-10);
}

TEST(LinearConjugateGradients, FindsWhatCholmodFinds) {
  for (const Rows<float>& a :
       {make_poisson(9, .3), random_definite(300, 4, 2), scalar_rows(make_elasticity(4)), tridiagonal(1)}) {
    const Array<float> b = random_vector<float>(a.rows, 3);
    const Eigen::VectorXd direct = to_eigen(DirectSolver(a)(b));
    const Eigen::VectorXd eigenvalues =
        Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(Eigen::MatrixXd(to_eigen(a))).eigenvalues();
    const double condition = eigenvalues.maxCoeff() / eigenvalues.minCoeff();
    ASSERT_LT((to_eigen(a) * direct - to_eigen(b)).norm(), 1e-12 * to_eigen(b).norm() * condition);

    // |x - x*| / |x*| <= cond |b - A x| / |b|.
    const Rows<float> diagonal = inverse_diagonal(a);
    Array<float> x(a.rows);
    const Solution s = serial::conjugate_gradients(
        serial_system<float>(a,
                             [&](std::span<const float> r, std::span<float> z) { serial::multiply(diagonal, r, z); }),
        b, x, {});
    EXPECT_LE(s.recursive_residual, 1e-6);
    EXPECT_NEAR(s.true_residual, (to_eigen(b) - to_eigen(a) * to_eigen(x)).norm() / to_eigen(b).norm(), 1e-9);
    EXPECT_LE((to_eigen(x) - direct).norm(), condition * s.true_residual * direct.norm());
    EXPECT_LE(s.true_residual, 1e-4);

    const Rows<double> truth = convert<double>(a), truth_diagonal = inverse_diagonal(truth);
    Array<double> y(a.rows);
    const Solution t = serial::conjugate_gradients(
        serial_system<double>(
            truth, [&](std::span<const double> r, std::span<double> z) { serial::multiply(truth_diagonal, r, z); }),
        convert<double>(b), y, {.tolerance = 1e-11});
    EXPECT_LE(t.true_residual, 2e-11);
    EXPECT_LE((to_eigen(y) - direct).norm(), condition * 3e-11 * direct.norm());
  }
}

TEST(LinearConjugateGradients, ReportsTheResidualThatFloatHides) {
  const Rows<float> a = make_poisson(32, .25);
  const Factor<float> f = serial::incomplete_cholesky(a, {});
  const Array<float> b = random_vector<float>(a.rows, 4);
  Array<float> x(a.rows);
  const Solution s = serial::conjugate_gradients(
      serial_system<float>(a, [&](std::span<const float> r, std::span<float> z) { serial::solve(f, r, z); }), b, x,
      {.tolerance = 1e-12});
  EXPECT_LE(s.recursive_residual, 1e-12);
  EXPECT_GT(s.true_residual, 1e-8);
  EXPECT_NEAR(s.true_residual, (to_eigen(b) - to_eigen(a) * to_eigen(x)).norm() / to_eigen(b).norm(),
              1e-3 * s.true_residual);
}

// Refreshed, the sum in double gets to residuals that a solution in float could not even hold.
TEST(LinearConjugateGradients, RefreshedReachTheToleranceInTruth) {
  const Rows<float> a = make_poisson(32, .25);
  const Factor<float> f = serial::incomplete_cholesky(a, {});
  const Array<float> b = random_vector<float>(a.rows, 4);
  const Eigen::VectorXd right = to_eigen(b);
  const EigenRows matrix = to_eigen(a);
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(a.rows);
  System<float> system =
      serial_system<float>(a, [&](std::span<const float> r, std::span<float> z) { serial::solve(f, r, z); });
  system.refresh = [&](std::span<float> x, std::span<float> r) {
    sum += Eigen::Map<Eigen::VectorXf>(x.data(), a.rows).cast<double>();
    std::fill(x.begin(), x.end(), 0.f);
    Eigen::Map<Eigen::VectorXf>(r.data(), a.rows) = (right - matrix * sum).cast<float>();
    return serial::dot(std::span<const float>(r), std::span<const float>(r));
  };
  Array<float> x(a.rows);
  const Solution s = serial::conjugate_gradients(system, b, x, {.tolerance = 1e-12});
  EXPECT_LE(s.true_residual, 1e-12);
  EXPECT_LE((right - matrix * sum).norm(), 1.001e-12 * right.norm());
  EXPECT_EQ(x, Array<float>(a.rows));

  // It takes hardly longer than in double: directions go on.
  const Rows<double> truth = convert<double>(a);
  const Factor<double> g = serial::incomplete_cholesky(truth, {});
  Array<double> y(a.rows);
  const Solution t = serial::conjugate_gradients(
      serial_system<double>(truth, [&](std::span<const double> r, std::span<double> z) { serial::solve(g, r, z); }),
      convert<double>(b), y, {.tolerance = 1e-12});
  std::printf("  %d iterations, in double %d\n", s.iterations, t.iterations);
  EXPECT_LE(s.iterations, t.iterations + t.iterations / 5);
}

TEST(LinearConjugateGradients, Ends) {
  Rows<float> a = tridiagonal(64);
  const auto nothing = [](std::span<const float> r, std::span<float> z) { std::copy(r.begin(), r.end(), z.begin()); };
  Array<float> b(64, 0), x(64, 5);
  EXPECT_EQ(serial::conjugate_gradients(serial_system<float>(a, nothing), b, x, {}).iterations, 0);
  EXPECT_EQ(x, Array<float>(64, 0));
  b[0] = 1;
  const Solution limited =
      serial::conjugate_gradients(serial_system<float>(a, nothing), b, x, {.tolerance = 1e-6, .iterations = 3});
  EXPECT_EQ(limited.iterations, 3);
  EXPECT_GT(limited.true_residual, 1e-3);
  // In exact arithmetic, as many iterations as there are different eigenvalues: n.
  EXPECT_LE(serial::conjugate_gradients(serial_system<float>(a, nothing), b, x, {}).iterations, 64);
  for (float& value : a.value) value = -value;
  EXPECT_EQ(serial::conjugate_gradients(serial_system<float>(a, nothing), b, x, {}).iterations, 0);
}

TEST(LinearConjugateGradients, HasTheSerialBits) {
  {
    const Rows<float> natural = make_poisson(40, .25);
    const Levels levels = make_levels(natural);
    const Rows<float> a = reordered(natural, levels.order);
    const SlicedRows sliced = slice(a);
    const Factor<float> f = serial::incomplete_cholesky(a, {});
    const SlicedFactor lanes_of_f = slice(f, levels);
    const Array<float> b = random_vector<float>(a.rows, 5);
    Array<float> x(a.rows);
    const Solution s = serial::conjugate_gradients(
        serial_system<float>(a, [&](std::span<const float> r, std::span<float> z) { serial::solve(f, r, z); }), b, x,
        {});
    EXPECT_LT(s.iterations, 60);
    at_each_thread_count([&] {
      Array<float> y(a.rows);
      const Solution o = openmp::conjugate_gradients(
          {[&](std::span<const float> p, std::span<float> q) { return openmp::multiply_and_dot(sliced, p, q); },
           [&](std::span<const float> r, std::span<float> z) {
             return openmp::solve(lanes_of_f, r, z), openmp::dot(r, z);
           },
           [&](std::span<const float> c, std::span<const float> z) { return residual_norm(a, c, z); }},
          b, y, {});
      EXPECT_EQ(o.iterations, s.iterations);
      EXPECT_EQ(o.recursive_residual, s.recursive_residual);
      EXPECT_TRUE(same_bits(y, x));
    });
  }
  const BlockRows<float> a = make_elasticity(7), diagonal = inverse_diagonal(a);
  const SlicedBlockRows sliced = slice(a), sliced_diagonal = slice(diagonal);
  const Array<float> b = random_vector<float>(3 * a.rows, 6);
  Array<float> x(b.size());
  const auto residual = [&](std::span<const float> c, std::span<const float> z) { return residual_norm(a, c, z); };
  const Solution s = serial::conjugate_gradients(
      {[&](std::span<const float> p, std::span<float> q) {
         serial::multiply(a, p, q);
         return serial::dot(p, std::span<const float>(q));
       },
       [&](std::span<const float> r, std::span<float> z) {
         return serial::multiply(diagonal, r, z), serial::dot(r, std::span<const float>(z));
       },
       residual},
      b, x, {});
  EXPECT_NEAR(s.true_residual, (to_eigen(b) - to_eigen(scalar_rows(a)) * to_eigen(x)).norm() / to_eigen(b).norm(),
              1e-3 * s.true_residual);
  at_each_thread_count([&] {
    Array<float> y(b.size());
    const Solution o = openmp::conjugate_gradients(
        {[&](std::span<const float> p, std::span<float> q) {
           openmp::multiply(sliced, p, q);
           return openmp::dot(p, q);
         },
         [&](std::span<const float> r, std::span<float> z) {
           return openmp::multiply(sliced_diagonal, r, z), openmp::dot(r, z);
         },
         residual},
        b, y, {});
    EXPECT_EQ(o.iterations, s.iterations);
    EXPECT_TRUE(same_bits(y, x));
  });
}

TEST(LinearConjugateGradients, InvertsTheBlocksOnTheDiagonal) {
  const BlockRows<float> a = make_elasticity(3);
  const BlockRows<double> inverse = inverse_diagonal(convert<double>(a));
  const Eigen::MatrixXd whole = to_eigen(scalar_rows(a)), inverted = to_eigen(scalar_rows(inverse));
  for (int i = 0; i < a.rows; ++i)
    EXPECT_LT(
        (whole.block<3, 3>(3 * i, 3 * i) * inverted.block<3, 3>(3 * i, 3 * i) - Eigen::Matrix3d::Identity()).norm(),
        1e-13);
}

}  // namespace
}  // namespace lockstep::linear
