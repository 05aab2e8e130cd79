// What advection asks of whole bricks (common/production_fluid/bricks.h).
#pragma once

#include "common/production_fluid/bricks.h"

namespace lockstep::production_fluid::serial {

// Whether `holds` is true of all of a field's values in a box.
template <class Real, class Predicate>
bool all_in(const Field<Real>& field, const Box& box, const Predicate& holds) {
  const auto [along_x, along_y, along_z] = inside(field, box);
  for (int z = along_z.begin; z < along_z.end; ++z)
    for (int y = along_y.begin; y < along_y.end; ++y)
      for (int x = along_x.begin; x < along_x.end; ++x)
        if (!holds(field(x, y, z))) return false;
  return true;
}

template <class Real>
void fill(Field<Real>& field, const Box& box, Real value) {
  const auto [along_x, along_y, along_z] = inside(field, box);
  for (int z = along_z.begin; z < along_z.end; ++z)
    for (int y = along_y.begin; y < along_y.end; ++y)
      for (int x = along_x.begin; x < along_x.end; ++x) field(x, y, z) = value;
}

}  // namespace lockstep::production_fluid::serial
