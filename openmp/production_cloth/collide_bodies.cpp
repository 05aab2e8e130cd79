// Vertices are pushed out of solid bodies, with friction: round after round, until a round finds a vertex in none of
// them.
//
// Sixteen vertices at once. A lane stays active from round to round as long as its vertex was inside something.
//
// The contract stands in common/production_cloth/collide_bodies.h.
#include "common/production_cloth/collide_bodies.h"

#include "common/real.h"
#include "common/simd.h"
#include "openmp/vector_lanes.h"

namespace lockstep::production_cloth::openmp {

using Number = floatv;
using Mask = maskv;

void collide_bodies(const MovedBodies<Real>& bodies, int vertices, Real time_step, const Array<Real>& inverse_mass,
                    const Vectors<Real>& start, Vectors<Real>& position, Vectors<Real>& velocity) {
  if (bodies.empty()) return;
  const Number per_step = 1 / time_step;
  const Vector3<const float*> p = pointers(start);
  const Vector3<float*> q = pointers(position), v = pointers(velocity);

  // Every vertex is one thread's.
#pragma omp parallel for schedule(static)
  for (int i = 0; i < vertices; i += lanes) {
    const Vector3<Number> from = load(p, i);
    Vector3<Number> to = load(q, i);
    const Mask moves = load(&inverse_mass[i]) > 0.f;
    Mask inside = moves, pushed = first_lanes(0);
    for (int round = 0; round < cloth::most_rounds && any(inside); ++round) {
      inside = push_out_of_all(bodies, from, inside, to);
      pushed |= inside;
    }
    if (none(pushed)) continue;
    store(q, i, to);
    store(v, i, select(pushed, per_step * (to - from), load(v, i)));
  }
}

}  // namespace lockstep::production_cloth::openmp
