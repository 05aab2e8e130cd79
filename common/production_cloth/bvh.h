// Contract: boxes around what a cloth's elements sweep in a step, and the boxes of the trees' nodes above them.
//
// The box of a vertex is around its positions at start and end, and wider by `margin` on every side: at least so much,
// rounding included, so the boxes of two elements that at any time are no farther from each other than 2 margin
// overlap. The box of an edge or a triangle is the smallest around those of its vertices, without rounding: a vertex's
// box is inside that of each of its triangles.
//
// In:  search; start, end, m, of all vertices, finite, padded; margin >= 0, m.
// Out: boxes, m, resized; all levels (common/production_cloth/search.h). No zero in them is negative.
//
// Source: [ITJ07] "Production Cloth" on the broad phase; Bridson, Fedkiw and Anderson 2002, section 6.
#pragma once

#include <limits>

#include "common/math.h"
#include "common/production_cloth/search.h"

namespace lockstep::production_cloth {

template <class Real>
using Refit = void(const Search& search, const Vectors<Real>& start, const Vectors<Real>& end, Real margin,
                   SearchBoxes<Real>& boxes);

namespace serial {
Refit<float> refit;
Refit<double> refit;
}  // namespace serial

namespace openmp {
Refit<float> refit;
}  // namespace openmp

// --- Formulas; of a number or of lanes

// x - margin is rounded by half a unit in the last place at most. epsilon |x - margin| is one unit at least, so taking
// it off again leaves a number that is no greater than the true difference. Subnormal differences are exact.
template <class Real, class V>
inline Box<V> swept_box(const Vector3<V>& from, const Vector3<V>& to, Real margin) {
  constexpr Real epsilon = std::numeric_limits<Real>::epsilon();
  const auto below = [=](const V& a, const V& b) {
    const V x = min(a, b) - margin;
    return x - epsilon * abs(x);
  };
  const auto above = [=](const V& a, const V& b) {
    const V x = max(a, b) + margin;
    return x + epsilon * abs(x);
  };
  return spatial::zeros_positive(Box<V>{{below(from.x, to.x), below(from.y, to.y), below(from.z, to.z)},
                                        {above(from.x, to.x), above(from.y, to.y), above(from.z, to.z)}});
}

}  // namespace lockstep::production_cloth
