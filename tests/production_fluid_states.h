// States in the tests of the production fluid.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/production_fluid/state.h"

namespace lockstep::production_fluid {

// All elements of a field, in its order.
template <class Real, class F>
void for_each_place(const Field<Real>& field, const F& f) {
  for (int z = 0; z < field.nz; ++z)
    for (int y = 0; y < field.ny; ++y)
      for (int x = 0; x < field.nx; ++x) f(x, y, z);
}

// Without obstacles and at rest, in a closed box; phi(x, y, z) of the centre of a cell, m.
template <class Real, class Phi>
Fluid<Real> make_fluid(int nx, int ny, int nz, double spacing, const Phi& phi) {
  const Real h = static_cast<Real>(spacing);
  Fluid<Real> fluid = {.nx = nx,
                       .ny = ny,
                       .nz = nz,
                       .spacing = h,
                       .open_top = false,
                       .phi = levelset::make_field<Real>(nx, ny, nz, h, 0),
                       .solid = levelset::make_field<Real>(nx, ny, nz, h, -1),
                       .velocity = make_faces<Real>(nx, ny, nz, h)};
  for_each_place(fluid.phi, [&](int x, int y, int z) {
    fluid.phi(x, y, z) = static_cast<Real>(phi((x + .5) * spacing, (y + .5) * spacing, (z + .5) * spacing));
    fluid.solid(x, y, z) = 1;
  });
  return fluid;
}

enum class Cell { liquid, air, closed };

// What is in a cell, or beyond the box.
template <class Real>
Cell cell_at(const Fluid<Real>& fluid, int x, int y, int z) {
  if (y == fluid.ny && fluid.open_top) return Cell::air;
  if (x < 0 || x >= fluid.nx || y < 0 || y >= fluid.ny || z < 0 || z >= fluid.nz) return Cell::closed;
  if (fluid.solid(x, y, z) < 0) return Cell::closed;
  return fluid.phi(x, y, z) < 0 ? Cell::liquid : Cell::air;
}

// Calls f(component, axis, x, y, z, before, behind) for each face: what is in the cells beside it.
template <class Real, class F>
void for_each_face(const Fluid<Real>& fluid, const Faces<Real>& faces, const F& f) {
  const Field<Real>* const components[] = {&faces.u, &faces.v, &faces.w};
  for (int axis = 0; axis < 3; ++axis)
    for_each_place(*components[axis], [&](int x, int y, int z) {
      f(*components[axis], axis, x, y, z, cell_at(fluid, x - (axis == 0), y - (axis == 1), z - (axis == 2)),
        cell_at(fluid, x, y, z));
    });
}

}  // namespace lockstep::production_fluid
