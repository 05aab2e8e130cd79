// Contract: the vector updates of conjugate gradients.
//
//   axpy      y += a x
//   advance   x += a p, then p = z + b p: the step along p, and the next direction, in one pass over p
//   descend   r -= a q; returns r . r, summed as dot does (common/linear/dot.h)
//
// Each product and each sum rounds once. Vectors of one call have one length, do not overlap, and need no alignment;
// nothing beyond their last element is touched.
//
// Source: Hestenes and Stiefel, Methods of conjugate gradients for solving linear systems (1952), equations 3:1.
#pragma once

#include <span>

namespace lockstep::linear {

template <class Real>
using Axpy = void(Real a, std::span<const Real> x, std::span<Real> y);
template <class Real>
using Advance = void(Real a, std::span<const Real> z, Real b, std::span<Real> x, std::span<Real> p);
template <class Real>
using Descend = double(Real a, std::span<const Real> q, std::span<Real> r);

namespace serial {
Axpy<float> axpy;
Axpy<double> axpy;
Advance<float> advance;
Advance<double> advance;
Descend<float> descend;
Descend<double> descend;
}  // namespace serial

namespace openmp {
Axpy<float> axpy;
Advance<float> advance;
Descend<float> descend;
}  // namespace openmp

}  // namespace lockstep::linear
