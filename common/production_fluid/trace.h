// Semi-Lagrangian advection of one value: where it comes from, and what stands there.
//
// A value moves with the liquid. What arrives at a point after dt was at the point's foot before. The foot is found by
// the midpoint rule against the velocity u, whose error in one step is of third order in dt:
//
//   middle = point - dt/2 u(point)
//   foot   = point - dt u(middle)
//
// Positions are in cells from the corner of the box. A velocity times dt / h is a number of cells.
//
// Source: Stam, Stable fluids, SIGGRAPH 1999; Bridson, Fluid Simulation for Computer Graphics, 2nd edition (2015), 3.1.
#pragma once

#include <cstdint>

#include "common/levelset/sample.h"
#include "common/math.h"
#include "common/production_fluid/state.h"
#include "common/vector3.h"

namespace lockstep::production_fluid {

// Where the first value of a field stands, in cells from the corner of the box.
inline constexpr Vector3<float> first_u = {0, .5f, .5f}, first_v = {.5f, 0, .5f}, first_w = {.5f, .5f, 0},
                                first_centre = {.5f, .5f, .5f};

// Number: a number or lanes.
template <class Number>
inline Number mean(const Number& a, const Number& b) {
  return Number(.5f) * (a + b);
}
template <class Number>
inline Number mean(const Number& a, const Number& b, const Number& c, const Number& d) {
  return Number(.25f) * ((a + b) + (c + d));
}

// The namesake of lanes (common/simd.h).
template <class Real>
struct Pair {
  Real first, second;
};
template <class Real>
inline Pair<Real> gather_pairs(const Real* base, std::int32_t index) {
  return {base[index], base[index + 1]};
}

// Where a coordinate lies along an axis of n points. At a point itself the fraction is 0, at the last one, too, so that
// the point's value is taken as it is. (levelset::between lets the last point be 1 of the way from the one before it.
// It needs two points, and it rounds.) A NaN counts as 0.
template <class Index, class Number>
inline levelset::Between<Number, Index> place(const Number& x, int n) {
  const Number inside = min(max(x, Number(0)), Number(static_cast<float>(n - 1)));
  const Index first = to_int(inside);
  return {first, inside - Number(to_float(first))};
}

// A field between its points, by trilinear interpolation; a position outside is clamped. `at` in points from the first.
// Beside the last point of a line, one value of its padding is read and counts nothing, if it is finite. Beyond the last
// line and plane nothing is read.
template <class Index, class Number, class Real>
inline Number sample(const Field<Real>& field, const Vector3<Number>& at) {
  const auto x = place<Index>(at.x, field.nx);
  const auto y = place<Index>(at.y, field.ny);
  const auto z = place<Index>(at.z, field.nz);
  const Index corner = (z.first * field.ny + y.first) * field.pitch + x.first;
  const Index to_line = select(y.first < Index(field.ny - 1), Index(field.pitch), Index(0));
  const Index to_plane = select(z.first < Index(field.nz - 1), Index(field.pitch * field.ny), Index(0));

  const auto along_x = [&](const Index& index) {
    const auto [first, second] = gather_pairs(&field.value[field.index(0, 0, 0)], index);
    return levelset::interpolate(first, second, x.fraction);
  };
  const Number near = levelset::interpolate(along_x(corner), along_x(corner + to_line), y.fraction);
  const Index behind = corner + to_plane;
  const Number far = levelset::interpolate(along_x(behind), along_x(behind + to_line), y.fraction);
  return levelset::interpolate(near, far, z.fraction);
}

// The same, `at` in cells from the corner of the box.
template <class Index, class Number, class Real>
inline Number sample(const Field<Real>& field, const Vector3<float>& first, const Vector3<Number>& at) {
  return sample<Index>(field, Vector3<Number>{at.x - Number(first.x), at.y - Number(first.y), at.z - Number(first.z)});
}

template <class Index, class Number, class Real>
inline Vector3<Number> velocity_at(const Faces<Real>& faces, const Vector3<Number>& at) {
  return {sample<Index>(faces.u, first_u, at), sample<Index>(faces.v, first_v, at),
          sample<Index>(faces.w, first_w, at)};
}

// `velocity` is that at the point, `cells` is dt / h.
template <class Index, class Number, class Real>
inline Vector3<Number> foot_of(const Vector3<Number>& point, const Vector3<Number>& velocity, const Faces<Real>& faces,
                               Real cells) {
  const Vector3<Number> middle = point - Number(Real(.5) * cells) * velocity;
  return point - Number(cells) * velocity_at<Index>(faces, middle);
}

}  // namespace lockstep::production_fluid
