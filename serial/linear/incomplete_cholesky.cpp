// The incomplete Cholesky factor and its solve, row by row in order.
//
// The contract stands in common/linear/incomplete_cholesky.h.
#include "common/linear/incomplete_cholesky.h"

#include "common/linear/eliminate.h"
#include "common/real.h"

namespace lockstep::linear::serial {

Factor<Real> incomplete_cholesky(const Rows<Real>& a, Modification modification) {
  Factor<Real> factor = make_factor(a);
  for (int i = 0; i < a.rows; ++i) eliminate(a, modification, i, factor);
  return factor;
}

void solve(const Factor<Real>& factor, std::span<const Real> r, std::span<Real> z) {
  const Rows<Real>&lower = factor.lower, &upper = factor.upper;
  const Array<Real>& inverse = factor.inverse;
  for (int i = 0; i < lower.rows; ++i) {
    Real sum = r[i];
    for (int k = lower.begin[i]; k < lower.begin[i + 1]; ++k) sum -= lower.value[k] * z[lower.column[k]];
    z[i] = inverse[i] * sum;
  }
  for (int i = upper.rows - 1; i >= 0; --i) {
    Real sum = 0;
    for (int k = upper.begin[i]; k < upper.begin[i + 1]; ++k) sum += upper.value[k] * z[upper.column[k]];
    z[i] -= inverse[i] * sum;
  }
}

}  // namespace lockstep::linear::serial
