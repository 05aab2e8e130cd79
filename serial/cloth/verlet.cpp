// Verlet integration under gravity, wind and drag.
//
// Velocity is not stored: it is what a particle has moved since the step before. Constraints then only need to move
// positions, and velocities follow. Wind pushes triangles, which have a side to push on; then every particle collects a
// third of the force on each triangle that it is a corner of.
//
// Source: [Jakobsen 2001] section 2. The contract stands in common/cloth/verlet.h, the formulas in common/cloth/aero.h.
#include "common/cloth/verlet.h"

#include "common/cloth/aero.h"
#include "common/real.h"

namespace lockstep::cloth::serial {
namespace {

Particle<Real> particle(const Vectors<Real>& p, const Vectors<Real>& q, int i) {
  return {load(p, i), load(p, i) - load(q, i)};
}

}  // namespace

void verlet(Cloth<Real>& cloth) {
  const Model<Real> model = cloth.model;  // a local copy: stores cannot change it
  Vectors<Real>&p = cloth.position, &q = cloth.previous, &forces = cloth.force;
  if (model.drag > 0) {
    const int triangles = static_cast<int>(cloth.triangles.size());
    for (int t = 0; t < triangles; ++t) {
      const auto [a, b, c] = cloth.triangles[t];
      store(forces, t, air_force(model, particle(p, q, a), particle(p, q, b), particle(p, q, c)));
    }
  }
  for (int i = 0; i < cloth.count; ++i) {
    Vector3<Real> force = {0, 0, 0};
    if (model.drag > 0)
      for (int k = cloth.corner_begin[i]; k < cloth.corner_begin[i + 1]; ++k)
        force = force + load(forces, cloth.corner[k]);
    const Vector3<Real> position = load(p, i), moved = position - load(q, i);
    store(q, i, position);
    store(p, i, next_position(model, position, moved, cloth.inverse_mass[i], force));
  }
}

}  // namespace lockstep::cloth::serial
