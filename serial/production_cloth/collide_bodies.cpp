// Vertices are pushed out of solid bodies, with friction: round after round, until a round finds a vertex in none of
// them.
//
// The contract stands in common/production_cloth/collide_bodies.h.
#include "common/production_cloth/collide_bodies.h"

#include "common/real.h"

namespace lockstep::production_cloth::serial {

using Number = Real;
using Mask = bool;

void collide_bodies(const MovedBodies<Real>& bodies, int vertices, Real time_step, const Array<Real>& inverse_mass,
                    const Vectors<Real>& start, Vectors<Real>& position, Vectors<Real>& velocity) {
  if (bodies.empty()) return;
  const Number per_step = 1 / time_step;
  for (int i = 0; i < vertices; ++i) {
    const Vector3<Number> from = load(start, i);
    Vector3<Number> to = load(position, i);
    const Mask moves = inverse_mass[i] > 0;
    Mask inside = moves, pushed = false;
    for (int round = 0; round < cloth::most_rounds && any(inside); ++round) {
      inside = push_out_of_all(bodies, from, inside, to);
      pushed |= inside;
    }
    if (none(pushed)) continue;
    store(position, i, to);
    store(velocity, i, select(pushed, per_step * (to - from), load(velocity, i)));
  }
}

}  // namespace lockstep::production_cloth::serial
