// Adds gravity to the velocity: each component of each face gets what gravity adds to it in a time step.
//
// The contract stands in common/production_fluid/apply_forces.h.
#include "common/production_fluid/apply_forces.h"

#include "common/real.h"

namespace lockstep::production_fluid::serial {
namespace {

void add(Real change, Field<Real>& component) {
  if (change == 0) return;
  for (int z = 0; z < component.nz; ++z)
    for (int y = 0; y < component.ny; ++y)
      for (int x = 0; x < component.nx; ++x) component(x, y, z) += change;
}

}  // namespace

void apply_forces(const Vector3<Real>& gravity, Real dt, Faces<Real>& faces) {
  add(dt * gravity.x, faces.u);
  add(dt * gravity.y, faces.v);
  add(dt * gravity.z, faces.w);
}

}  // namespace lockstep::production_fluid::serial
