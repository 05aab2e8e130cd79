// A liquid with a free surface on a MAC grid (marker and cell): pressure and surface stand at the centres of cells,
// velocities on their faces.
//
// Cells are cubes of side h = `spacing` that fill a box with a corner at the origin. Cell (x, y, z) has its centre at
// ((x + .5) h, (y + .5) h, (z + .5) h). Its faces are u(x, y, z) and u(x + 1, y, z) along x, v(x, y, z) and
// v(x, y + 1, z) along y, w(x, y, z) and w(x, y, z + 1) along z.
//
// A cell is solid where solid < 0, else liquid where phi < 0, else air. The sides of the box are walls. Where the top
// is open, there is air above it. A face is closed if a solid cell or a wall is beside it.
//
// Source: Harlow and Welch, Phys. Fluids 8 (1965). The level set: Enright, Marschner and Fedkiw, Animation and
//         rendering of complex water surfaces, SIGGRAPH 2002; [ITJ07] "Production Fluid".
#pragma once

#include <algorithm>

#include "common/convert.h"
#include "common/levelset/field.h"
#include "common/vector3.h"

namespace lockstep::production_fluid {

using levelset::Field;

// Velocities on faces, m/s: u has nx + 1 faces along x, v ny + 1 along y, w nz + 1 along z.
template <class Real>
struct Faces {
  Field<Real> u, v, w;
};

template <class Real>
struct Fluid {
  int nx = 0, ny = 0, nz = 0;  // cells
  Real spacing = 0;            // m
  bool open_top = false;
  Field<Real> phi;    // m, at cell centres: < 0 in the liquid
  Field<Real> solid;  // m, at cell centres: < 0 in obstacles, which do not move, and in the padding
  Faces<Real> velocity;
};

// Number: a number or lanes.
template <class Number>
inline auto is_solid(const Number& solid) {
  return solid < Number(0);
}
template <class Number>
inline auto is_liquid(const Number& phi, const Number& solid) {
  return (phi < Number(0)) & !is_solid(solid);
}
template <class Number>
inline auto is_air(const Number& phi, const Number& solid) {
  return !(phi < Number(0)) & !is_solid(solid);
}
// The share of a cell of side h that is liquid, from 0 to 1, as if the surface were a plane across an axis.
inline double liquid_share(double phi, double h) { return std::clamp(.5 - phi / h, 0., 1.); }
// Whether the face between two cells is closed.
template <class Number>
inline auto is_closed(const Number& solid_a, const Number& solid_b) {
  return is_solid(solid_a) | is_solid(solid_b);
}

template <class Real>
Faces<Real> make_faces(int nx, int ny, int nz, Real spacing) {
  using levelset::make_field;
  return {make_field<Real>(nx + 1, ny, nz, spacing, 0), make_field<Real>(nx, ny + 1, nz, spacing, 0),
          make_field<Real>(nx, ny, nz + 1, spacing, 0)};
}

template <Is<Faces> V, class F>
void for_each_array(V& faces, const F& f) {
  f("u", faces.u.value, faces.u.value.size());
  f("v", faces.v.value, faces.v.value.size());
  f("w", faces.w.value, faces.w.value.size());
}

template <Is<Fluid> T, class F>
void for_each_array(T& fluid, const F& f) {
  f("phi", fluid.phi.value, fluid.phi.value.size());
  f("solid", fluid.solid.value, fluid.solid.value.size());
  for_each_array(fluid.velocity, f);
}

template <class To, class From>
Field<To> convert(const Field<From>& field) {
  return {
      field.nx, field.ny, field.nz, static_cast<To>(field.spacing), field.pitch, lockstep::convert<To>(field.value)};
}
template <class To, class From>
Faces<To> convert(const Faces<From>& faces) {
  return {convert<To>(faces.u), convert<To>(faces.v), convert<To>(faces.w)};
}
template <class To, class From>
Fluid<To> convert(const Fluid<From>& fluid) {
  return {fluid.nx,
          fluid.ny,
          fluid.nz,
          static_cast<To>(fluid.spacing),
          fluid.open_top,
          convert<To>(fluid.phi),
          convert<To>(fluid.solid),
          convert<To>(fluid.velocity)};
}

}  // namespace lockstep::production_fluid
