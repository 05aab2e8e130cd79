// The loop of conjugate gradients, which is sequential: one text for serial/ and openmp/, which pass their kernels in.
#pragma once

#include <algorithm>
#include <cmath>

#include "common/linear/conjugate_gradients.h"
#include "common/linear/dot.h"
#include "common/linear/update.h"

namespace lockstep::linear {

template <class Real>
Solution iterate(Dot<Real>& dot, Axpy<Real>& axpy, Advance<Real>& advance, Descend<Real>& descend,
                 const System<Real>& system, std::span<const Real> b, std::span<Real> x, const Stop& stop) {
  std::fill(x.begin(), x.end(), Real(0));
  const double norm_of_b = std::sqrt(dot(b, b));
  if (norm_of_b == 0) return {};

  Array<Real> r(b.begin(), b.end()), z(b.size()), p(b.size()), q(b.size());
  Solution solution{.iterations = 0, .recursive_residual = 1, .true_residual = 1};
  const auto done = [&] {
    return !(solution.recursive_residual > stop.tolerance) || solution.iterations >= stop.iterations;
  };
  double rz = 0;
  Real step = 0;  // along p; x takes it when the next direction is made, or at the end
  while (!done()) {
    system.precondition(r, z);
    const double rz_before = rz;
    rz = dot(r, z);
    if (solution.iterations == 0)
      std::copy(z.begin(), z.end(), p.begin());
    else
      advance(step, z, static_cast<Real>(rz / rz_before), x, p);
    const double pq = system.multiply(p, q);
    if (!(pq > 0)) break;
    step = static_cast<Real>(rz / pq);
    solution.recursive_residual = std::sqrt(descend(step, q, r)) / norm_of_b;
    ++solution.iterations;
    if (done()) axpy(step, p, x);
  }
  solution.true_residual = system.residual(b, x) / norm_of_b;
  return solution;
}

}  // namespace lockstep::linear
