// Along which axis boxes are swept. Sums are cut into blocks, so that threads can share them out and get the same bits.
#pragma once

#include <algorithm>

#include "common/spatial/bounds.h"

namespace lockstep::spatial {

inline constexpr int sum_block = 1024;  // boxes

template <class T>
const T& along(const Vector3<T>& v, int axis) {
  return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}
template <class Real>
const Array<Real>& along(const Vectors<Real>& v, int axis) {
  return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

// The sum of term(box) over the bounded boxes of the block that begins at box `first`.
template <class Real, class Term>
Vector3<Real> sum_of_block(const Bounds<Real>& bounds, int first, const Term& term) {
  Vector3<Real> sum = {0, 0, 0};
  for (int i = first; i < std::min(first + sum_block, bounds.count); ++i)
    if (bounds.bounded(i)) sum = sum + term(bounds.box(i));
  return sum;
}

// The axis on which the centres of boxes have the greatest variance, the first of equals. sum(term) is the sum of
// term(box) over all bounded boxes: the sums of the blocks, added up in order.
template <class Real, class Sum>
int widest_axis(const Sum& sum) {
  const auto twice_centre = [](const Box<Real>& box) { return box.low + box.high; };
  const Vector3<Real> n = sum([](const Box<Real>&) { return Vector3<Real>{1, 1, 1}; });
  const Vector3<Real> mean = 1 / max(n.x, Real(1)) * sum(twice_centre);
  const Vector3<Real> variance = sum([&](const Box<Real>& box) {
    const Vector3<Real> off = twice_centre(box) - mean;
    return Vector3<Real>{off.x * off.x, off.y * off.y, off.z * off.z};
  });
  return variance.x >= variance.y ? (variance.x >= variance.z ? 0 : 2) : (variance.y >= variance.z ? 1 : 2);
}

}  // namespace lockstep::spatial
