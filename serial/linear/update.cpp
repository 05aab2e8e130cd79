// The vector updates of conjugate gradients.
//
// The contract stands in common/linear/update.h.
#include "common/linear/update.h"

#include <cstddef>

#include "common/linear/dot.h"
#include "common/real.h"

namespace lockstep::linear::serial {

void axpy(Real a, std::span<const Real> x, std::span<Real> y) {
  for (std::size_t i = 0; i < y.size(); ++i) y[i] += a * x[i];
}

void advance(Real a, std::span<const Real> z, Real b, std::span<Real> x, std::span<Real> p) {
  for (std::size_t i = 0; i < p.size(); ++i) {
    x[i] += a * p[i];
    p[i] = z[i] + b * p[i];
  }
}

double descend(Real a, std::span<const Real> q, std::span<Real> r) {
  for (std::size_t i = 0; i < r.size(); ++i) r[i] -= a * q[i];
  return dot(r, r);
}

}  // namespace lockstep::linear::serial
