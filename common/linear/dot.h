// Contract: the dot product of two vectors, with the same bits whatever the number of threads.
//
//   x . y = sum over blocks of 1024 elements, in order, of the block's sum
//   a block's sum: lane l of sixteen adds the products of elements l, l + 16, l + 32, ... of the block, in order;
//   the lanes are added in the tree ((0 + 8) + (4 + 12)) + ((2 + 10) + (6 + 14)) + ...
//
// All in double: the product of two floats is exact there, and the sum is wrong by at most
// (64 + 4 + n / 1024) 2^-53 sum|x y| (notes/linear.md).
//
// In: x and y, of one length; any alignment, nothing beyond the last element is read. An empty product is 0.
//
// Source: [ITJ07] has dot products in all three production applications; a fixed order of sums in place of a reduction:
//         Demmel and Nguyen, Fast reproducible floating-point summation (ARITH 2013), section 1.
#pragma once

#include <span>

namespace lockstep::linear {

inline constexpr int dot_block = 1024;  // elements
inline constexpr int dot_lanes = 16;

template <class Real>
using Dot = double(std::span<const Real> x, std::span<const Real> y);

namespace serial {
Dot<float> dot;
Dot<double> dot;
}  // namespace serial

namespace openmp {
Dot<float> dot;
}  // namespace openmp

}  // namespace lockstep::linear
