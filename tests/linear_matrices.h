// What tests of the linear kernels share: random vectors and matrices, Eigen's view of a matrix, and running at several
// numbers of threads.
#pragma once

#include <gtest/gtest.h>
#include <omp.h>

#include <cstring>
// As wherever Eigen is used here: what it inlines and how it allocates depends on this, and must not differ between
// files.
#ifndef EIGEN_DONT_VECTORIZE
#define EIGEN_DONT_VECTORIZE
#endif
#include <eigen3/Eigen/Dense>
#include <eigen3/Eigen/Sparse>
#include <map>
#include <random>
#include <span>
#include <vector>

#include "common/linear/matrix.h"

namespace lockstep::linear {

// Numbers from -1 to 1, multiples of 2^-20.
template <class Real>
Array<Real> random_vector(std::size_t n, int seed) {
  std::mt19937 random(seed);
  Array<Real> x(n);
  for (Real& e : x) e = static_cast<Real>(static_cast<int>(random() % (1 << 21)) - (1 << 20)) / (1 << 20);
  return x;
}

template <class Real>
std::span<const Real> view(const Array<Real>& x) {
  return x;
}

// Rows of up to `most` entries at random columns; some rows are empty.
inline Rows<float> random_rows(int rows, int columns, int most, int seed) {
  std::mt19937 random(seed);
  Rows<float> a;
  a.rows = rows, a.columns = columns;
  for (int i = 0; i < rows; ++i) {
    std::map<int, float> row;
    for (int k = random() % (most + 1); k > 0; --k)
      row[random() % columns] = static_cast<float>(static_cast<int>(random() % 2001) - 1000) / 999;
    for (const auto& [column, value] : row) a.column.push_back(column), a.value.push_back(value);
    a.begin.push_back(static_cast<int>(a.column.size()));
  }
  return a;
}

inline BlockRows<float> random_block_rows(int rows, int columns, int most, int seed) {
  const Rows<float> pattern = random_rows(rows, columns, most, seed);
  BlockRows<float> a;
  a.rows = rows, a.columns = columns, a.begin = pattern.begin, a.column = pattern.column;
  a.value = random_vector<float>(9 * a.column.size(), seed + 1);
  return a;
}

// Symmetric, and positive definite as each diagonal entry exceeds the sum of the others' sizes.
inline Rows<float> random_definite(int n, int a_row, int seed) {
  std::mt19937 random(seed);
  std::vector<std::map<int, float>> row(n);
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < a_row; ++k)
      if (const int j = random() % n; j != i)
        row[i][j] = row[j][i] = static_cast<float>(static_cast<int>(random() % 2001) - 1000) / 999;
  Rows<float> a;
  a.rows = a.columns = n;
  for (int i = 0; i < n; ++i) {
    float sum = .125f;
    for (const auto& [column, value] : row[i]) sum += std::abs(value);
    row[i][i] = sum;
    for (const auto& [column, value] : row[i]) a.column.push_back(column), a.value.push_back(value);
    a.begin.push_back(static_cast<int>(a.column.size()));
  }
  return a;
}

// -1, 2, -1 of n unknowns.
inline Rows<float> tridiagonal(int n) {
  Rows<float> a;
  a.rows = a.columns = n;
  for (int i = 0; i < n; ++i) {
    for (const int j : {i - 1, i, i + 1})
      if (j >= 0 && j < n) a.column.push_back(j), a.value.push_back(j == i ? 2 : -1);
    a.begin.push_back(static_cast<int>(a.column.size()));
  }
  return a;
}

using EigenRows = Eigen::SparseMatrix<double, Eigen::RowMajor>;

template <class Real>
EigenRows to_eigen(const Rows<Real>& a) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < a.rows; ++i)
    for (int k = a.begin[i]; k < a.begin[i + 1]; ++k) entries.emplace_back(i, a.column[k], a.value[k]);
  EigenRows e(a.rows, a.columns);
  e.setFromTriplets(entries.begin(), entries.end());
  return e;
}

template <class Real>
Eigen::MatrixXd to_dense(const BlockRows<Real>& a) {
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(3 * a.rows, 3 * a.rows);
  for (int i = 0; i < a.rows; ++i)
    for (int b = a.begin[i]; b < a.begin[i + 1]; ++b)
      for (int e = 0; e < 9; ++e) dense(3 * i + e / 3, 3 * a.column[b] + e % 3) = a.value[9 * std::size_t(b) + e];
  return dense;
}
template <class Real>
Eigen::VectorXd to_eigen(const Array<Real>& x) {
  return Eigen::Map<const Eigen::Matrix<Real, Eigen::Dynamic, 1>>(x.data(), static_cast<Eigen::Index>(x.size()))
      .template cast<double>();
}

// Says where two vectors first differ in their bits.
inline testing::AssertionResult same_bits(std::span<const float> a, std::span<const float> b) {
  if (a.size() != b.size()) return testing::AssertionFailure() << a.size() << " and " << b.size() << " elements";
  for (std::size_t i = 0; i < a.size(); ++i)
    if (std::memcmp(&a[i], &b[i], sizeof(float)) != 0)
      return testing::AssertionFailure() << "element " << i << ": " << a[i] << " and " << b[i];
  return testing::AssertionSuccess();
}

// Runs `action` with 1, 2, 3 and 8 threads.
template <class Action>
void at_each_thread_count(const Action& action) {
  const int before = omp_get_max_threads();
  for (const int threads : {1, 2, 3, 8}) {
    SCOPED_TRACE(testing::Message() << threads << " threads");
    omp_set_num_threads(threads);
    action();
  }
  omp_set_num_threads(before);
}

}  // namespace lockstep::linear
