// Semi-Lagrangian advection of one value: the point that it comes from, and the interpolated value there.
//
// A value moves with the liquid. What arrives at a point after dt was at the point's foot before. The foot is found by
// the midpoint rule against the velocity u, whose error in one step is of third order in dt:
//
//   middle = point - dt/2 u(point)
//   foot   = point - dt u(middle)
//
// Positions are in cells from the corner of the box. A velocity times dt / h is a number of cells.
//
// Source: Stam, Stable fluids, SIGGRAPH 1999; Bridson, Fluid Simulation for Computer Graphics.
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

// Where a coordinate lies along an axis of n points. At a point itself the fraction is 0, at the last one, too, so that
// the point's value is taken as it is. (levelset::between lets the last point be 1 of the way from the one before it.
// It needs two points, and it rounds.) A NaN counts as 0.
template <class Index, class Number>
inline levelset::Between<Number, Index> place(const Number& x, int n) {
  const Number inside = min(max(x, Number(0)), Number(static_cast<float>(n - 1)));
  const Index first = to_int(inside);
  return {first, inside - Number(to_float(first))};
}

// Eight neighbouring points of a field: where the first stands, counted from the point (0, 0, 0), and how far it is to
// the next line and to the next plane. Beside the last line or plane there is none, and the distance is 0.
template <class Index>
struct Cell {
  Index first, to_line, to_plane;
};

// The eight values, by dx + 2 dy + 4 dz. openmp/production_fluid/corners.h has the same for lanes.
template <class Number>
struct Corners {
  Number value[8];
};
template <class Real>
inline Corners<Real> load_corners(const Real* field, const Cell<std::int32_t>& cell) {
  const Real* const line = field + cell.first;
  const Real* const next = line + cell.to_line;
  const std::int32_t plane = cell.to_plane;
  return {line[0], line[1], next[0], next[1], line[plane], line[plane + 1], next[plane], next[plane + 1]};
}

// How sample and velocity_at load the values of a cell by default.
struct LoadCorners {
  template <class Real, class Index>
  auto operator()(const Real* field, const Cell<Index>& cell) const {
    return load_corners(field, cell);
  }
};

// Trilinear interpolation: along x, then y, then z.
template <class Number>
inline Number interpolate(const Corners<Number>& c, const Number& x, const Number& y, const Number& z) {
  using levelset::interpolate;
  const auto along_x = [&](int line) { return interpolate(c.value[2 * line], c.value[2 * line + 1], x); };
  const Number near = interpolate(along_x(0), along_x(1), y);
  const Number far = interpolate(along_x(2), along_x(3), y);
  return interpolate(near, far, z);
}

// How the interpolation changes along each axis, per cell.
template <class Number>
inline Vector3<Number> slope(const Corners<Number>& c, const Number& x, const Number& y, const Number& z) {
  using levelset::interpolate;
  const auto rise = [&](int line) { return c.value[2 * line + 1] - c.value[2 * line]; };
  const auto along_x = [&](int line) { return interpolate(c.value[2 * line], c.value[2 * line + 1], x); };
  const Number line[] = {along_x(0), along_x(1), along_x(2), along_x(3)};
  return {interpolate(interpolate(rise(0), rise(1), y), interpolate(rise(2), rise(3), y), z),
          interpolate(line[1] - line[0], line[3] - line[2], z),
          interpolate(line[2], line[3], y) - interpolate(line[0], line[1], y)};
}

// The cell that begins at a point of a field.
template <class Index, class Real>
inline Cell<Index> cell_of(const Field<Real>& field, const Index& x, const Index& y, const Index& z) {
  return {
      .first = (z * field.ny + y) * field.pitch + x,
      .to_line = select(y < Index(field.ny - 1), Index(field.pitch), Index(0)),
      .to_plane = select(z < Index(field.nz - 1), Index(field.pitch * field.ny), Index(0)),
  };
}

// Where a position lies in a field: in which cell, and how far along it. `first` is where the field's first value
// stands.
template <class Number, class Index>
struct Spot {
  Cell<Index> cell;
  Vector3<Number> along;
};
template <class Index, class Number, class Real>
inline Spot<Number, Index> spot_of(const Field<Real>& field, const Vector3<float>& first, const Vector3<Number>& at) {
  const auto x = place<Index>(at.x - Number(first.x), field.nx), y = place<Index>(at.y - Number(first.y), field.ny),
             z = place<Index>(at.z - Number(first.z), field.nz);
  return {cell_of(field, x.first, y.first, z.first), {x.fraction, y.fraction, z.fraction}};
}

// A field between its points. Beside the last point of a line, a value of its padding is read and counts nothing, if it
// is finite.
template <class Number, class Index, class Real, class Load = LoadCorners>
inline Number sample(const Field<Real>& field, const levelset::Between<Number, Index>& x,
                     const levelset::Between<Number, Index>& y, const levelset::Between<Number, Index>& z,
                     const Load& load = {}) {
  const Cell<Index> cell = cell_of(field, x.first, y.first, z.first);
  return interpolate(load(&field.value[field.index(0, 0, 0)], cell), x.fraction, y.fraction, z.fraction);
}

// The same at a position; one outside the field is clamped. `first` is where the field's first value stands.
template <class Index, class Number, class Real, class Load = LoadCorners>
inline Number sample(const Field<Real>& field, const Vector3<float>& first, const Vector3<Number>& at,
                     const Load& load = {}) {
  return sample(field, place<Index>(at.x - Number(first.x), field.nx), place<Index>(at.y - Number(first.y), field.ny),
                place<Index>(at.z - Number(first.z), field.nz), load);
}

// Each component on its own grid. Two of the three grids agree along each axis.
template <class Index, class Number, class Real, class Load = LoadCorners>
inline Vector3<Number> velocity_at(const Faces<Real>& faces, const Vector3<Number>& at, const Load& load = {}) {
  const auto& [u, v, w] = faces;
  const auto face_x = place<Index>(at.x, u.nx), x = place<Index>(at.x - Number(.5f), v.nx);
  const auto face_y = place<Index>(at.y, v.ny), y = place<Index>(at.y - Number(.5f), u.ny);
  const auto face_z = place<Index>(at.z, w.nz), z = place<Index>(at.z - Number(.5f), u.nz);
  return {sample(u, face_x, y, z, load), sample(v, x, face_y, z, load), sample(w, x, y, face_z, load)};
}

// `velocity` is that at the point, `cells` is dt / h.
template <class Index, class Number, class Real>
inline Vector3<Number> foot_of(const Vector3<Number>& point, const Vector3<Number>& velocity, const Faces<Real>& faces,
                               Real cells) {
  const Vector3<Number> middle = point - Number(Real(.5) * cells) * velocity;
  return point - Number(cells) * velocity_at<Index>(faces, middle);
}

}  // namespace lockstep::production_fluid
