// Contract: a field between its points, by trilinear interpolation.
//
// The value at a position is that of the eight points around it, interpolated along x, then y, then z:
//
//   a + t (b - a),  t = how far the position lies from a to b, 0 .. 1
//
// A position outside the grid takes the value of the nearest position on its boundary.
//
// In:      field, at least two points along each axis, fewer than 2^31 values with padding; `count` positions, m from
//          the point (0, 0, 0), one array a component, padded (common/array.h). A NaN counts as 0.
// Out:     value[0 .. count - 1], in the field's unit; room for padded(count).
// Source:  what semi-Lagrangian advection reads (Stam, Stable fluids, SIGGRAPH 1999); [ITJ07] "Production Fluid".
#pragma once

#include <cstdint>

#include "common/levelset/field.h"
#include "common/math.h"
#include "common/vector3.h"

namespace lockstep::levelset {

template <class Real>
using Sample = void(const Field<Real>& field, int count, const Vectors<Real>& position, Array<Real>& value);

namespace serial {
Sample<float> sample;
Sample<double> sample;
}  // namespace serial

namespace openmp {
Sample<float> sample;
}  // namespace openmp

// Where a coordinate lies along an axis: `fraction` of the way from point `first` to the next. Number and Index: a
// scalar and std::int32_t, or floatv and intv.
template <class Number, class Index>
struct Between {
  Index first;
  Number fraction;
};

// x in spacings, n points along the axis.
template <class Index, class Number>
inline Between<Number, Index> between(Number x, int n) {
  const Number inside = min(max(x, Number(0)), Number(static_cast<float>(n - 1)));
  const Index truncated = to_int(inside), last = n - 2;
  const Index first = select(truncated < last, truncated, last);
  return {first, inside - Number(to_float(first))};
}

template <class Number>
inline Number interpolate(Number a, Number b, Number t) {
  return a + t * (b - a);
}

}  // namespace lockstep::levelset
