// The upwind solution of |grad u| = 1 at a point, written once: for numbers in serial/, for sixteen lanes in openmp/.
#pragma once

#include "common/math.h"

namespace lockstep::levelset {

// The distance u at a point from the least distances a, b, c of its neighbours along each axis, to first order:
//
//   sum of ((u - v) / h)^2 = 1 over those v of a, b, c that are less than u.
//
// Sort so that a <= b <= c. Using v - a instead of v avoids cancellation. b counts if the one-term solution lies beyond
// it, a + h > b; c if the two-term solution does, which is where the two-term sum at u = c is below 1. One square root,
// and divisions by 1, 2 or 3 only. V is a number, or lanes.
template <class V>
[[gnu::always_inline]] inline V upwind(V a, V b, V c, V h) {
  const V low = min(a, b), high = max(a, b);
  const V least = min(low, c), most = max(high, c), middle = max(low, min(high, c));
  const V p = middle - least, q = most - least;
  const auto two = p < h, three = q * q + (q - p) * (q - p) < h * h;
  const V sum = select(three, p + q, select(two, p, V(0)));
  const V squares = select(three, p * p + q * q, select(two, p * p, V(0)));
  const V n = select(three, V(3), select(two, V(2), V(1)));
  const V per_n = select(three, V(1) / V(3), select(two, V(.5f), V(1)));
  return least + (sum + sqrt(max(sum * sum - n * (squares - h * h), V(0)))) * per_n;
}

}  // namespace lockstep::levelset
