// Sparse matrix times vector, row by row.
//
// The contract stands in common/linear/multiply.h.
#include "common/linear/multiply.h"

#include <cstddef>

#include "common/linear/dot.h"
#include "common/real.h"

namespace lockstep::linear::serial {

void multiply(const Rows<Real>& a, std::span<const Real> x, std::span<Real> y) {
  for (int i = 0; i < a.rows; ++i) {
    Real sum = 0;
    for (int k = a.begin[i]; k < a.begin[i + 1]; ++k) sum += a.value[k] * x[a.column[k]];
    y[i] = sum;
  }
}

double multiply_and_dot(const Rows<Real>& a, std::span<const Real> x, std::span<Real> y) {
  multiply(a, x, y);
  return dot(x, y);
}

void multiply(const BlockRows<Real>& a, std::span<const Real> x, std::span<Real> y) {
  for (int i = 0; i < a.rows; ++i) {
    Real sum[3] = {0, 0, 0};
    for (int k = a.begin[i]; k < a.begin[i + 1]; ++k) {
      const Real* const block = &a.value[9 * static_cast<std::size_t>(k)];
      const Real* const at = &x[3 * static_cast<std::size_t>(a.column[k])];
      for (int r = 0; r < 3; ++r) sum[r] += block[3 * r] * at[0] + block[3 * r + 1] * at[1] + block[3 * r + 2] * at[2];
    }
    for (int r = 0; r < 3; ++r) y[3 * static_cast<std::size_t>(i) + r] = sum[r];
  }
}

void residual(const BlockRows<Real>& a, std::span<const Real> b, std::span<const double> x, std::span<Real> r) {
  for (int i = 0; i < a.rows; ++i) {
    double rest[3];
    for (int c = 0; c < 3; ++c) rest[c] = b[3 * static_cast<std::size_t>(i) + c];
    for (int k = a.begin[i]; k < a.begin[i + 1]; ++k) {
      const Real* const block = &a.value[9 * static_cast<std::size_t>(k)];
      const double* const at = &x[3 * static_cast<std::size_t>(a.column[k])];
      const auto entry = [&](int j, int c) { return static_cast<double>(block[3 * j + c]); };
      for (int j = 0; j < 3; ++j)
        for (int c = 0; c < 3; ++c) rest[j] = rest[j] - entry(j, c) * at[c];
    }
    for (int c = 0; c < 3; ++c) r[3 * static_cast<std::size_t>(i) + c] = static_cast<Real>(rest[c]);
  }
}

}  // namespace lockstep::linear::serial
