// Contract: A x = b by preconditioned conjugate gradients, A symmetric and positive definite.
//
//   x = 0, r = b, z = M^-1 r, p = z;  then, as long as |r| > tolerance |b| and there are iterations left,
//
//   a = (r . z) / (p . A p);  x += a p;  r -= a A p;  z = M^-1 r;  p = z + (r . z) / (r . z before) p
//
// The operator and the preconditioner are the caller's (System). Dot products are sums in double of a fixed order
// (common/linear/dot.h), a and the factor of p are rounded to Real, so a solve has the same bits at every number of
// threads if its system has.
//
// The residual r that the iteration carries along is not b - A x: rounding moves the two apart, and in float r falls to
// any tolerance while b - A x stays near 2^-24 |A| |x| (Greenbaum, SIAM J. Matrix Anal. Appl. 18, 1997). So the true
// residual is reported, too.
//
// With System::refresh the true residual reaches the tolerance, too. Whenever |r| has fallen to a hundredth of the last
// true residual, x is added to a sum in double that the system keeps, r becomes the true residual, and x becomes 0;
// directions are kept, so that convergence does not begin anew. The sum is 0 at first. In the end it is the solution,
// and x is 0.
//
// With System::start, too, the sum begins with a guess; with 0 if that leaves a residual greater than b, or NaN.
//
// In: system; b. Out: x. Vectors of one length; x and b do not overlap. b = 0 gives x = 0 in no iteration. Stops, too,
// where p . A p <= 0 or is NaN: A is then not positive definite, or x has overflowed.
//
// Source: refreshing: Sleijpen and van der Vorst, Reliable updated residuals in hybrid Bi-CG methods, Computing 56
//         (1996). Hestenes and Stiefel (1952); Saad, Iterative Methods for Sparse Linear Systems (2nd ed., 2003),
//         algorithm 9.1.
#pragma once

#include <functional>
#include <span>

#include "common/array.h"
#include "common/linear/matrix.h"

namespace lockstep::linear {

template <class Real>
struct System {
  std::function<double(std::span<const Real> x, std::span<Real> y)> multiply;      // y = A x; returns x . y (dot.h)
  std::function<double(std::span<const Real> x, std::span<Real> y)> precondition;  // y = M^-1 x; returns x . y
  // |b - A x|, computed in double (residual_norm). Not called if there is `refresh`. May be absent: the true residual
  // of the solution is then NaN.
  std::function<double(std::span<const Real> b, std::span<const Real> x)> residual;
  // Adds x to the sum and sets x to 0; r = b - A (the sum), computed in double; returns r . r. May be absent.
  std::function<double(std::span<Real> x, std::span<Real> r)> refresh = {};
  // Sets the sum to the guess, or to 0. Needs `refresh`. May be absent: the sum is 0 before the loop.
  std::function<void(bool to_guess)> start = {};
};

struct Stop {
  double tolerance = 1e-6;  // of |r| / |b|, in the 2-norm
  int iterations = 1000;    // at most
};

struct Solution {
  int iterations = 0;
  double recursive_residual = 0;  // |r| / |b|
  double true_residual = 0;       // |b - A x| / |b|
};

template <class Real>
using ConjugateGradients = Solution(const System<Real>& system, std::span<const Real> b, std::span<Real> x,
                                    const Stop& stop);

namespace serial {
ConjugateGradients<float> conjugate_gradients;
ConjugateGradients<double> conjugate_gradients;
}  // namespace serial

namespace openmp {
ConjugateGradients<float> conjugate_gradients;
}  // namespace openmp

// --- What systems are made of

// The inverse of the diagonal, as a matrix: the product with it is Jacobi's preconditioner. Each row must have a
// diagonal entry that is not 0.
template <class Real>
Rows<Real> inverse_diagonal(const Rows<Real>& a);

// The same of 3x3 blocks, inverted in double: block Jacobi. Each block on the diagonal must have an inverse.
template <class Real>
BlockRows<Real> inverse_diagonal(const BlockRows<Real>& a);

// |b - A x| in the 2-norm, products and sums in double.
template <class Real>
double residual_norm(const Rows<Real>& a, std::span<const Real> b, std::span<const Real> x);
template <class Real>
double residual_norm(const BlockRows<Real>& a, std::span<const Real> b, std::span<const Real> x);

}  // namespace lockstep::linear
