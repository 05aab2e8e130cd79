// Contract: the vector updates of conjugate gradients.
//
//   axpy      y += a x
//   xpay      p = z + b p
//   descend   x += a p, r -= a q; returns r . r, summed as dot does (common/linear/dot.h)
//
// Each product and each sum rounds once. Vectors of one call have one length, do not overlap, and may stand anywhere;
// nothing beyond their last element is touched.
//
// Source: Hestenes and Stiefel, Methods of conjugate gradients for solving linear systems (1952), equations 3:1.
#pragma once

#include <span>

namespace lockstep::linear {

template <class Real>
using Axpy = void(Real a, std::span<const Real> x, std::span<Real> y);
template <class Real>
using Xpay = void(std::span<const Real> z, Real b, std::span<Real> p);
template <class Real>
using Descend = double(Real a, std::span<const Real> p, std::span<const Real> q, std::span<Real> x, std::span<Real> r);

namespace serial {
Axpy<float> axpy;
Axpy<double> axpy;
Xpay<float> xpay;
Xpay<double> xpay;
Descend<float> descend;
Descend<double> descend;
}  // namespace serial

namespace openmp {
Axpy<float> axpy;
Xpay<float> xpay;
Descend<float> descend;
}  // namespace openmp

}  // namespace lockstep::linear
