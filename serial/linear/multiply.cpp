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

}  // namespace lockstep::linear::serial
