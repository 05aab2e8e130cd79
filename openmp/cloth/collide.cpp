// Particles are pushed out of solid bodies, with friction (common/cloth/push_out.h): round after round, until a round
// finds a particle in none of them.
//
// Sixteen particles at once. A lane stays active from round to round as long as its particle was inside something.
//
// Source: [Jakobsen 2001] sections 3 and 6. The contract stands in common/cloth/collide.h.
#include "common/cloth/collide.h"

#include "common/cloth/push_out.h"
#include "common/real.h"
#include "common/simd.h"
#include "openmp/vector_lanes.h"

namespace lockstep::cloth::openmp {

using Number = floatv;
using Mask = maskv;

void collide(Cloth<Real>& cloth) {
  const auto& bodies = cloth.bodies;
  if (bodies.planes.empty() && bodies.capsules.empty() && bodies.boxes.empty()) return;
  const Vector3<float*> p = pointers(cloth.position), q = pointers(cloth.previous);
  const float* const inverse_mass = cloth.inverse_mass.data();
  const Real friction = bodies.friction;

  // Every particle is one thread's.
#pragma omp parallel for schedule(static)
  for (int i = 0; i < cloth.count; i += lanes) {
    Vector3<Number> position = load(p, i);
    const Vector3<Number> start = load(q, i);
    Mask inside = load(inverse_mass + i) > 0.f;
    for (int round = 0; round < most_rounds && any(inside); ++round) {
      const Mask active = inside;
      inside = first_lanes(0);
      for (const Plane<Real>& plane : bodies.planes) inside |= push_out(plane, friction, start, active, position);
      for (const Capsule<Real>& capsule : bodies.capsules)
        inside |= push_out(capsule, friction, start, active, position);
      for (const Box<Real>& box : bodies.boxes) inside |= push_out(box, friction, start, active, position);
    }
    store(p, i, position);
  }
}

}  // namespace lockstep::cloth::openmp
