// MacCormack's correction of semi-Lagrangian advection A, for one value.
//
//   arrived  = A(q)              what stands at the foot (trace.h)
//   returned = A^-1(arrived)     what arrived, carried back: the same trace with -dt
//   advected = arrived + (q - returned) / 2
//
// Without an error of A, returned would be q. Both ways make the same error, to the leading order. Half of the
// difference takes that of one way off, so a smooth field is carried with an error of second order instead of first.
//
// Where a field is not smooth, what is corrected can leave the range of the eight values that the foot lies between.
// Then advected = arrived: however long the step, no value leaves the range of those before.
//
// Nor is there a correction where the foot or the one with -dt lies outside the field's points. The value there is that
// of the boundary, and the difference says nothing of A.
//
// Source: Selle, Fedkiw, Kim, Liu and Rossignac, An unconditionally stable MacCormack method, J. Sci. Comput. 35
//         (2008).
#pragma once

#include "common/levelset/sample.h"
#include "common/math.h"
#include "common/production_fluid/state.h"
#include "common/production_fluid/trace.h"
#include "common/vector3.h"

namespace lockstep::production_fluid {

// What arrived at each point, and the least and the greatest value that it may be corrected to. Of fields, or of faces.
template <class Values>
struct Arrived {
  Values value, least, most;
};

// The same at one point.
template <class Number>
struct Bounded {
  Number value, least, most;
};

// Whether a position lies among the points of a field, of which the first stands at `first`.
template <class Number, class Real>
inline auto is_among(const Field<Real>& field, const Vector3<float>& first, const Vector3<Number>& at) {
  const auto along = [](const Number& x, int n) { return (x >= Number(0)) & (x <= Number(static_cast<float>(n - 1))); };
  return along(at.x - Number(first.x), field.nx) & along(at.y - Number(first.y), field.ny) &
         along(at.z - Number(first.z), field.nz);
}

// What stands at a foot, bounded by the eight values around it; by itself, if the foot is outside.
template <class Index, class Number, class Real, class Load = LoadCorners>
inline Bounded<Number> sample_bounded(const Field<Real>& field, const Vector3<float>& first, const Vector3<Number>& at,
                                      const Load& load = {}) {
  const auto x = place<Index>(at.x - Number(first.x), field.nx), y = place<Index>(at.y - Number(first.y), field.ny),
             z = place<Index>(at.z - Number(first.z), field.nz);
  const Corners<Number> c = load(&field.value[field.index(0, 0, 0)], cell_of(field, x.first, y.first, z.first));
  // Beside the last point of a line stands padding, which is no value of the field.
  const auto is_last = x.first == Index(field.nx - 1);
  const auto beside = [&](int line) { return select(is_last, c.value[2 * line], c.value[2 * line + 1]); };
  Number least = min(c.value[0], beside(0)), most = max(c.value[0], beside(0));
  for (int line = 1; line < 4; ++line) {
    least = min(least, min(c.value[2 * line], beside(line)));
    most = max(most, max(c.value[2 * line], beside(line)));
  }
  const Number value = interpolate(c, x.fraction, y.fraction, z.fraction);
  const auto among = is_among(field, first, at);
  return {value, select(among, least, value), select(among, most, value)};
}

// What is advected to a point where q was. `values` has what arrived everywhere, `back` is the foot with -dt.
template <class Index, class Number, class Real, class Load = LoadCorners>
inline Number corrected(const Number& q, const Bounded<Number>& arrived, const Field<Real>& values,
                        const Vector3<float>& first, const Vector3<Number>& back, const Load& load = {}) {
  const Number returned = sample<Index>(values, first, back, load);
  const Number better = arrived.value + Number(.5f) * (q - returned);
  const auto holds = (better >= arrived.least) & (better <= arrived.most) & is_among(values, first, back);
  return select(holds, better, arrived.value);
}

}  // namespace lockstep::production_fluid
