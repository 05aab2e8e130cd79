// How deep a box reaches below a plane. For T a scalar or floatv.
#pragma once

#include "common/spatial/bounds.h"

namespace lockstep::rigid {

// The height of a box's lowest corner over the plane through `point`, m. Rounding keeps order, so that no corner comes
// out lower.
template <class T, class Real>
inline T lowest_corner(const spatial::Box<T>& box, const Vector3<Real>& normal, const Vector3<Real>& point) {
  const auto lower = [](const T& low, const T& high, Real n, Real p) { return ((n > 0 ? low : high) - p) * n; };
  return lower(box.low.x, box.high.x, normal.x, point.x) + lower(box.low.y, box.high.y, normal.y, point.y) +
         lower(box.low.z, box.high.z, normal.z, point.z);
}

}  // namespace lockstep::rigid
