// Walls push back particles that are about to come too near.
//
// Only particles in a cell at a wall are tested, at the position of the next step: a stiff spring over the last fifth
// of a millimetre, and a damper. Particles do not touch one another here, so the compiler turns the scalar text into
// lanes: the papers' "straightforward with autovectorizer".
//
// Source: [LRB08] Figure 7, "Process Collisions". The contract stands in common/fluid/collisions.h.
#include "common/fluid/collisions.h"

#include "common/fluid/motion.h"
#include "common/real.h"

namespace lockstep::fluid::openmp {
namespace {

// The walls at the two ends of one axis, for this thread's share of the particles; it is called by all threads of a
// region.
void collide_with_walls(const Model<Real>& model, const Axis<Real>& axis, int count, const Array<Real>& position,
                        const Array<Real>& half_velocity, const Array<Real>& velocity, Array<Real>& acceleration) {
  // Iterations are independent: particle i writes acceleration[i] alone. Axes have arrays of their own: no loop waits
  // for another.
#pragma omp for simd schedule(static) nowait
  for (int i = 0; i < count; ++i) push_back(model, axis, position[i], half_velocity[i], velocity[i], acceleration[i]);
}

}  // namespace

void collisions(const Model<Real>& model, const Grid<Real>& grid, const Particles<Real>& particles,
                Vectors<Real>& acceleration) {
  if (!model.walls) return;
  const Vectors<Real>&p = particles.position, &hv = particles.half_velocity, &v = particles.velocity;
  // One region for the three axes; see collide_with_walls.
#pragma omp parallel
  {
    collide_with_walls(model, grid.x, particles.count, p.x, hv.x, v.x, acceleration.x);
    collide_with_walls(model, grid.y, particles.count, p.y, hv.y, v.y, acceleration.y);
    collide_with_walls(model, grid.z, particles.count, p.z, hv.z, v.z, acceleration.z);
  }
}

}  // namespace lockstep::fluid::openmp
