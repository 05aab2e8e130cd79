// Model matrices, their layout for lanes, and products: against Eigen's in double, within their bounds, with the serial
// bits.
#include <cmath>
#include <limits>
#include <set>

#include "common/linear/dot.h"
#include "common/linear/make.h"
#include "common/linear/multiply.h"
#include "tests/linear_matrices.h"

namespace lockstep::linear {
namespace {

// --- Model matrices

TEST(LinearMake, PoissonCountsOpenFaces) {
  const int n = 9;
  const Rows<float> a = make_poisson(n, .25);
  EXPECT_LT(a.rows, n * n * n);
  const EigenRows e = to_eigen(a);
  EXPECT_EQ((e - EigenRows(e.transpose())).norm(), 0);
  // A row sums to 0, but under the air to 1.
  const Eigen::VectorXd sums = e * Eigen::VectorXd::Ones(a.columns);
  EXPECT_EQ(sums.sum(), n * n);
  EXPECT_EQ(sums.minCoeff(), 0);
  EXPECT_EQ(sums.maxCoeff(), 1);
  EXPECT_EQ(make_poisson(4, 0).rows, 64);
  EXPECT_EQ(make_poisson(1, 0).value, (Array<float>{1}));
}

TEST(LinearMake, ElasticityStretchesAsABarDoes) {
  // Symmetric to the bit. Translations strain nothing but the held layer, and the patch test: where displacements are
  // linear in the place, forces of points inside are 0.
  const int n = 5;
  const Rows<float> a = scalar_rows(make_elasticity(n));
  const EigenRows e = to_eigen(a);
  EXPECT_EQ((e - EigenRows(e.transpose())).norm(), 0);
  Eigen::VectorXd moved(3 * n * n * n), stretched(3 * n * n * n);
  for (int i = 0; i < n * n * n; ++i)
    for (int c = 0; c < 3; ++c) {
      const int at[] = {i % n + 1, i / n % n, i / n / n};
      moved[3 * i + c] = 1 + c;
      stretched[3 * i + c] = .3 * at[c] - .2 * at[(c + 1) % 3];
    }
  for (int i = 0; i < n * n * n; ++i)
    for (int c = 0; c < 3; ++c) {
      const auto inside = [](int k) { return k > 0 && k < n - 1; };
      if (i % n == 0) continue;
      EXPECT_NEAR((e * moved)[3 * i + c], 0, 1e-5);  // 27 blocks of float
      if (inside(i % n) && inside(i / n % n) && inside(i / n / n)) {
        EXPECT_NEAR((e * stretched)[3 * i + c], 0, 1e-5);
      }
    }
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(Eigen::MatrixXd(e)).eigenvalues().minCoeff(), 0);
}

// --- Layout

TEST(LinearSliced, StoresRunsOnce) {
  const Rows<float> poisson = make_poisson(32, 0);
  const SlicedRows s = slice(poisson);
  EXPECT_TRUE(s.column.empty());
  EXPECT_LT(bytes_of(s), 12. * poisson.rows);
  const SlicedRows random = slice(random_rows(200, 5000, 12, 1));
  EXPECT_FALSE(random.column.empty());
}

TEST(LinearSliced, KeepsGroupsApart) {
  const std::int32_t groups[] = {0, 5, 5, 40};
  const SlicedRows s = slice(tridiagonal(40), groups);
  EXPECT_EQ(s.first_row, (Array<std::int32_t>{0, 5, 21, 37, 40}));
}

TEST(LinearSliced, PadsBlockRowsLittle) {
  const BlockRows<float> a = random_block_rows(1000, 1000, 30, 2);
  const SlicedBlockRows s = slice(a);
  EXPECT_LT(static_cast<double>(s.column.size()), 1.1 * static_cast<double>(a.column.size()));
  std::multiset<std::int32_t> rows(s.row.begin(), s.row.end());
  for (int i = 0; i < a.rows; ++i) EXPECT_EQ(rows.count(i), 1u);
}

// --- Products

// |float - double| <= u (m + 1) sum |a x| for m products and m additions in order, u = 2^-24, and 2 u^2 for what is of
// higher order.
void expect_product(const Rows<float>& a, const Array<float>& x, std::span<const float> y, int additions) {
  const EigenRows e = to_eigen(a);
  const Eigen::VectorXd truth = e * to_eigen(x), sizes = e.cwiseAbs() * to_eigen(x).cwiseAbs();
  for (int i = 0; i < a.rows; ++i) EXPECT_LE(std::abs(y[i] - truth[i]), (additions + 1) * 0x1.001p-24 * sizes[i]) << i;
}

int longest(const auto& a) {
  int most = 0;
  for (int i = 0; i < a.rows; ++i) most = std::max(most, a.begin[i + 1] - a.begin[i]);
  return most;
}

TEST(LinearMultiply, RowsAreEigens) {
  const Rows<float> matrices[] = {make_poisson(13, .3),
                                  random_rows(1, 1, 1, 3),
                                  random_rows(257, 100, 20, 4),
                                  random_rows(33, 1000, 90, 5),
                                  random_rows(50, 3, 3, 6),
                                  tridiagonal(1),
                                  tridiagonal(100),
                                  Rows<float>{},
                                  random_rows(40, 7, 0, 7),
                                  scalar_rows(make_elasticity(4))};
  for (const Rows<float>& a : matrices) {
    const Array<float> x = random_vector<float>(a.columns, 8);
    Array<float> y(a.rows, 77);
    serial::multiply(a, x, y);
    expect_product(a, x, y, longest(a));
    const SlicedRows sliced = slice(a);
    at_each_thread_count([&] {
      Array<float> z(a.rows + 3, 77);
      openmp::multiply(sliced, x, std::span(z).first(a.rows));
      EXPECT_TRUE(same_bits(std::span(z).first(a.rows), y));
      EXPECT_TRUE(same_bits(std::span(z).last(3), Array<float>(3, 77)));
    });
  }
}

TEST(LinearMultiply, BlockRowsAreEigens) {
  BlockRows<float> none = random_block_rows(20, 9, 0, 1);
  const BlockRows<float> matrices[] = {make_elasticity(2),
                                       make_elasticity(7),
                                       random_block_rows(1, 1, 1, 2),
                                       random_block_rows(300, 50, 20, 3),
                                       random_block_rows(17, 900, 40, 4),
                                       none,
                                       BlockRows<float>{}};
  for (const BlockRows<float>& a : matrices) {
    const Array<float> x = random_vector<float>(3 * a.columns, 8);
    Array<float> y(3 * a.rows, 77);
    serial::multiply(a, x, y);
    expect_product(scalar_rows(a), x, y, 3 + longest(a));
    const SlicedBlockRows sliced = slice(a);
    at_each_thread_count([&] {
      Array<float> z(3 * a.rows + 3, 77);
      openmp::multiply(sliced, x, std::span(z).first(3 * a.rows));
      EXPECT_TRUE(same_bits(std::span(z).first(3 * a.rows), y));
      EXPECT_TRUE(same_bits(std::span(z).last(3), Array<float>(3, 77)));
    });
  }
}

TEST(LinearMultiply, AddsUpItsDotProductAsDotDoes) {
  for (const Rows<float>& a : {make_poisson(13, .3), random_definite(1024, 3, 1), random_definite(1041, 4, 2),
                               random_definite(15, 2, 3), tridiagonal(1), Rows<float>{}}) {
    Array<float> x = random_vector<float>(a.columns, 9), y(a.rows);
    // So that order shows.
    for (std::size_t i = 0; i < x.size(); ++i) x[i] *= std::ldexp(1.f, static_cast<int>(i % 60));
    serial::multiply(a, x, y);
    const double product = serial::dot(view(x), view(y));
    Array<float> z(a.rows, 77);
    EXPECT_EQ(serial::multiply_and_dot(a, x, z), product);
    EXPECT_TRUE(same_bits(z, y));
    const SlicedRows sliced = slice(a);
    at_each_thread_count([&] {
      Array<float> w(a.rows + 3, 77);
      EXPECT_EQ(openmp::multiply_and_dot(sliced, x, std::span(w).first(a.rows)), product);
      EXPECT_TRUE(same_bits(std::span(w).first(a.rows), y));
      EXPECT_TRUE(same_bits(std::span(w).last(3), Array<float>(3, 77)));
    });
  }
}

TEST(LinearMultiply, UsesOnlyColumnsThatHaveEntries) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  Rows<float> a = tridiagonal(40);
  BlockRows<float> blocks;
  blocks.rows = blocks.columns = 20;
  for (int i = 0; i < 20; ++i) {
    if (i % 3 == 1) blocks.column.push_back(19), blocks.value.insert(blocks.value.end(), 9, 1.f);
    blocks.begin.push_back(static_cast<int>(blocks.column.size()));
  }
  a.columns = 50;
  Array<float> x(60, nan), y(60, 77), z(60, 77);
  std::fill_n(x.begin(), 40, 1.f);
  openmp::multiply(slice(a), std::span(x).first(50), std::span(y).first(40));
  for (int i = 0; i < 40; ++i) EXPECT_EQ(y[i], i == 0 || i == 39 ? 1 : 0);
  std::fill_n(x.begin() + 57, 3, 2.f);
  std::fill_n(x.begin(), 57, nan);
  openmp::multiply(slice(blocks), x, z);
  for (int i = 0; i < 60; ++i) EXPECT_EQ(z[i], i / 3 % 3 == 1 ? 6 : 0);
}

TEST(LinearMultiply, IsSymmetricToRounding) {
  const BlockRows<float> a = make_elasticity(6);
  const SlicedBlockRows sliced = slice(a);
  const Array<float> x = random_vector<float>(3 * a.rows, 1), y = random_vector<float>(3 * a.rows, 2);
  Array<float> ax(x.size()), ay(x.size());
  openmp::multiply(sliced, x, ax);
  openmp::multiply(sliced, y, ay);
  const Eigen::VectorXd sizes = to_eigen(scalar_rows(a)).cwiseAbs() * to_eigen(y).cwiseAbs();
  const double bound = 2 * (3 + 27 + 1) * 0x1.001p-24 * to_eigen(x).cwiseAbs().dot(sizes);
  EXPECT_NEAR(to_eigen(x).dot(to_eigen(ay)), to_eigen(y).dot(to_eigen(ax)), bound);
}

}  // namespace
}  // namespace lockstep::linear
