// Walls push back on the particles that are about to come too near.
//
// Only the particles in a cell at a wall are asked, and by where they will be, not where they are: a stiff spring over the
// last fifth of a millimetre, and a damper. Particles do not touch one another here, so the compiler turns the scalar text into
// lanes: the papers' "straightforward with autovectorizer".
//
// Source: [LRB08] Figure 7, "Process Collisions". The contract stands in common/fluid/collisions.h.
#include "common/fluid/collisions.h"

#include "common/real.h"

namespace lockstep::fluid::openmp {
namespace {

// The walls at the two ends of one axis.
void push_back(const Model<Real>& model, const Axis<Real>& axis, int count, const Array<Real>& position, const Array<Real>& half_velocity,
               const Array<Real>& velocity, Array<Real>& acceleration) {
  // Iterations are independent: particle i writes acceleration[i] alone.
#pragma omp parallel for simd schedule(static)
  for (int i = 0; i < count; ++i) {
    const int cell = cell_coordinate(axis, position[i]);
    const Real next = position[i] + half_velocity[i] * model.time_step;
    const Real depth_min = model.wall_reach - (next - axis.min);
    const Real depth_max = model.wall_reach - (axis.max - next);
    const Real push_min = model.wall_stiffness * depth_min - model.wall_damping * velocity[i];
    const Real push_max = model.wall_stiffness * depth_max + model.wall_damping * velocity[i];
    acceleration[i] += cell == 0 && depth_min > model.wall_min_depth ? push_min : 0;
    acceleration[i] -= cell == axis.cells - 1 && depth_max > model.wall_min_depth ? push_max : 0;
  }
}

}  // namespace

void collisions(const Model<Real>& model, const Grid<Real>& grid, const Particles<Real>& particles, Vectors<Real>& acceleration) {
  if (!model.walls) return;
  const Vectors<Real>&p = particles.position, &hv = particles.half_velocity, &v = particles.velocity;
  push_back(model, grid.x, particles.count, p.x, hv.x, v.x, acceleration.x);
  push_back(model, grid.y, particles.count, p.y, hv.y, v.y, acceleration.y);
  push_back(model, grid.z, particles.count, p.z, hv.z, v.z, acceleration.z);
}

}  // namespace lockstep::fluid::openmp
