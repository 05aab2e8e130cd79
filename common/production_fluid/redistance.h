// Contract: the level set becomes the signed distance from its own surface again.
//
//   phi = -d where phi < 0, else d
//
// Beside the surface, d = |phi| / s. s is how steep phi is, as far as two measures of |grad phi| agree: by differences
// with the cells on both sides, and by those towards the surface alone. Where one says steeper than a distance and the
// other flatter, s = 1. On a smooth surface the measures err in different ways, and at an edge the first is too small:
// by either alone, each redistancing would move the surface a little (notes/production_fluid.md). Where s is not
// between 1/2 and 2, d is the distance that levelset/ finds from the crossings of phi (common/levelset/initialize.h).
// The other cells get the distance that levelset/ computes from these, as far as `band`, and `band` beyond. So the
// surface stays where phi crosses 0, to first order.
//
// Where the surface is smooth, cells with |phi| < reach_of_closest_points then get their distance from its closest
// point (closest_point.h), of second order, but no more than half a cell from the one that they had. Distances of first
// order are too large beside a ball, and as the next advection reads them, the ball loses volume.
//
//   sweeping   by one round of fast sweeping. In a narrow band one round leaves rounding (notes/levelset.md).
//   marching   by fast marching in blocks.
//
// In, out: phi, finite. Padding is not changed.
// In:      band, m, > 0.
// Scratch: distances; any content, which afterwards is unspecified.
// Errors:  std::bad_alloc.
// Source:  [ITJ07] "Production Fluid", Figures 6 to 8. PhysBAM, too, goes from the crossings to the surface along phi's
//          slope.
#pragma once

#include "common/levelset/field.h"
#include "common/math.h"
#include "common/production_fluid/closest_point.h"
#include "common/production_fluid/state.h"
#include "common/vector3.h"

namespace lockstep::production_fluid {

using levelset::Distances;

template <class Real>
using Redistance = void(Field<Real>& phi, Real band, Distances<Real>& distances);

namespace serial {
Redistance<float> redistance_sweeping, redistance_marching;
Redistance<double> redistance_sweeping, redistance_marching;
}  // namespace serial

namespace openmp {
Redistance<float> redistance_sweeping, redistance_marching;
}  // namespace openmp

// How far the step redistances, in cells: where nothing moves by more than a cell, phi is still known 3 cells from the
// surface after a step.
inline constexpr float band_of_level_set = 4;

// In cells. The next advection moves the surface by what is within two cells of it, and redistancing then looks a cell
// farther.
inline constexpr float reach_of_closest_points = 3;

// --- Formulas; of numbers or of lanes

// How steep phi is at a cell, 1 for a distance. Beyond the box, phi is what it is here. load(index) is an element of
// phi, counted from cell (0, 0, 0).
template <class Index, class Real, class Load>
inline auto steepness(const Field<Real>& phi, const Index& x, const Index& y, const Index& z, const Load& load) {
  const Index place = (z * Index(phi.ny) + y) * Index(phi.pitch) + x;
  using Number = decltype(load(place));
  const Number here = load(place);
  Number both_sides(0), downhill(0);
  const auto add_axis = [&](const Index& at, int n, int step) {
    const auto has_low = at > Index(0), has_high = at < Index(n - 1);
    const Number low = load(place - select(has_low, Index(step), Index(0))),
                 high = load(place + select(has_high, Index(step), Index(0)));
    const Number rise = select(has_low & has_high, Number(.5f), Number(1)) * (high - low);
    both_sides = both_sides + rise * rise;
    const Number fall = max(select(here < Number(0), max(low, high) - here, here - min(low, high)), Number(0));
    downhill = downhill + fall * fall;
  };
  add_axis(x, phi.nx, 1), add_axis(y, phi.ny, phi.pitch), add_axis(z, phi.nz, phi.pitch * phi.ny);
  const Number one(1), a = sqrt(both_sides) / Number(phi.spacing), b = sqrt(downhill) / Number(phi.spacing);
  return select((a > one) & (b > one), min(a, b), select((a < one) & (b < one), max(a, b), one));
}

// The distance of a cell beside the surface.
template <class Number>
inline Number refined_distance(const Number& phi, const Number& steepness, const Number& from_crossings) {
  const auto nearly = (steepness >= Number(.5f)) & (steepness <= Number(2));
  return select(nearly, abs(phi) / select(nearly, steepness, Number(1)), from_crossings);
}

// The distance of a cell within reach of closest points, which had `distance`. It follows `distance` without jumps, so
// that sweeping and marching, which differ by rounding, still do.
template <class Number>
inline Number closest_distance(const ClosestPoint<Number>& closest, const Number& distance, const Number& band,
                               const Number& spacing) {
  const Number d = min(distance, band), half = Number(.5f) * spacing;
  return select(closest.is_smooth, min(max(closest.distance, d - half), d + half), d);
}

template <class Number>
inline Number signed_distance(const Number& phi, const Number& distance, const Number& band) {
  const Number d = min(distance, band);
  return select(phi < Number(0), Number(0) - d, d);
}

}  // namespace lockstep::production_fluid
