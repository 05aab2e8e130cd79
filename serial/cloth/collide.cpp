// Particles are pushed out of solid bodies, with friction (common/cloth/push_out.h): round after round, until a round
// finds a particle in none of them.
//
// Source: [Jakobsen 2001] sections 3 and 6. The contract stands in common/cloth/collide.h.
#include "common/cloth/collide.h"

#include "common/cloth/push_out.h"
#include "common/real.h"

namespace lockstep::cloth::serial {

using Number = Real;
using Mask = bool;

void collide(Cloth<Real>& cloth) {
  const auto& bodies = cloth.bodies;
  const Real friction = bodies.friction;
  for (int i = 0; i < cloth.count; ++i) {
    Vector3<Number> position = load(cloth.position, i);
    const Vector3<Number> start = load(cloth.previous, i);
    Mask inside = cloth.inverse_mass[i] > 0;
    for (int round = 0; round < most_rounds && any(inside); ++round) {
      const Mask active = inside;
      inside = false;
      for (const Plane<Real>& plane : bodies.planes) inside |= push_out(plane, friction, start, active, position);
      for (const Capsule<Real>& capsule : bodies.capsules)
        inside |= push_out(capsule, friction, start, active, position);
      for (const Box<Real>& box : bodies.boxes) inside |= push_out(box, friction, start, active, position);
    }
    store(cloth.position, i, position);
  }
}

}  // namespace lockstep::cloth::serial
