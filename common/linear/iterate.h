// The loop of conjugate gradients, which is sequential: one text for serial/ and openmp/, which pass their kernels in,
// and for domains whose vectors have an order of their own.
#pragma once

#include <cmath>
#include <span>
#include <type_traits>

#include "common/linear/conjugate_gradients.h"
#include "common/linear/dot.h"
#include "common/linear/update.h"

namespace lockstep::linear {

// The share of the last true residual at which it is computed anew.
inline constexpr double refresh_at = 1e-2;

template <class Real>
struct VectorKernels {
  Dot<Real>& dot;
  Axpy<Real>& axpy;
  Advance<Real>& advance;
  Descend<Real>& descend;
};

// The vectors of the loop: the solution, the residual, M^-1 r and the direction. All are 0 before the loop. The caller
// owns them, so that it can zero them with all threads, in memory that it keeps from solve to solve.
template <class Real>
struct Work {
  std::span<Real> x, r, z, p;
};

// Vectors has functions dot, axpy, advance and descend, as dot.h and update.h say. In place of `advance` it may have
// advance_and_multiply(a, b, x, p, z): advance(a, z, b, x, p), then system.multiply(p, z), whose result it returns.
// Then system.multiply is not called, and system.precondition may leave to that function what remains to be done for z.
template <class Real, class Vectors>
Solution iterate(Vectors&& vectors, const System<Real>& system, std::type_identity_t<std::span<const Real>> b,
                 const std::type_identity_t<Work<Real>>& work, const Stop& stop) {
  const auto [x, r, z, p] = work;
  const double norm_of_b = std::sqrt(vectors.dot(b, b));
  if (norm_of_b == 0) {
    if (system.start) system.start(false);
    return {};
  }

  const std::span<Real> q = z;  // A p, in the place of z, which is not read after p is made
  Solution solution{.iterations = 0, .recursive_residual = 1, .true_residual = 1};
  double& residual = solution.recursive_residual;
  double refreshed = 1;  // the last true residual
  const auto begin_with = [&](bool guess) {
    system.start(guess);
    residual = refreshed = std::sqrt(system.refresh(work.x, work.r)) / norm_of_b;
  };
  if (system.start)
    begin_with(true);
  else
    vectors.axpy(1, b, r);
  if (!(residual <= 1)) begin_with(false);
  bool is_refreshed = system.refresh != nullptr;  // x is 0, and the sum is the whole solution
  const auto done = [&] { return !(residual > stop.tolerance) || solution.iterations >= stop.iterations; };
  double rz = 0;
  Real step = 0;  // along p; added to x when the next direction is made, or at the end
  while (!done()) {
    const double rz_before = rz;
    rz = system.precondition(r, z);
    const Real beta = solution.iterations == 0 ? Real(0) : static_cast<Real>(rz / rz_before);  // at first, p = z
    double pq;
    if constexpr (requires { &std::remove_cvref_t<Vectors>::advance_and_multiply; }) {
      pq = vectors.advance_and_multiply(step, beta, x, p, q);
    } else {
      vectors.advance(step, z, beta, x, p);
      pq = system.multiply(p, q);
    }
    if (!(pq > 0)) break;
    step = static_cast<Real>(rz / pq);
    residual = std::sqrt(vectors.descend(step, q, r)) / norm_of_b;
    ++solution.iterations;
    is_refreshed = system.refresh && (residual <= refresh_at * refreshed || done());
    if (is_refreshed || done()) vectors.axpy(step, p, x), step = 0;
    if (is_refreshed) residual = refreshed = std::sqrt(system.refresh(x, r)) / norm_of_b;
  }
  if (is_refreshed)
    solution.true_residual = refreshed;
  else if (system.refresh)  // the loop may have ended before x was added to the sum
    solution.true_residual = std::sqrt(system.refresh(x, r)) / norm_of_b;
  else
    solution.true_residual = system.residual ? system.residual(b, x) / norm_of_b : std::nan("");
  return solution;
}

}  // namespace lockstep::linear
