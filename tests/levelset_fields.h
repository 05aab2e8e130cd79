// Fields in the tests of the level set.
#pragma once

#include <limits>

#include "common/levelset/field.h"

namespace lockstep::levelset {

// All points of a grid, in the order of the field.
template <class Action>
void for_each_point(const auto& grid, Action action) {
  for (int z = 0; z < grid.nz; ++z)
    for (int y = 0; y < grid.ny; ++y)
      for (int x = 0; x < grid.nx; ++x) action(x, y, z);
}

template <class Real>
Field<Real> field_of(int nx, int ny, int nz, Real spacing, auto phi) {
  // What padding holds must not matter.
  Field<Real> field = make_field<Real>(nx, ny, nz, spacing, std::numeric_limits<Real>::quiet_NaN());
  for_each_point(field, [&](int x, int y, int z) { field(x, y, z) = static_cast<Real>(phi(x, y, z)); });
  return field;
}

}  // namespace lockstep::levelset
