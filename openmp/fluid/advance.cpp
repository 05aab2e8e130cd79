// One leapfrog step, then what came out through a wall is put back.
//
// Velocities at half steps move the positions at whole steps, which costs no more than Euler's method and is second order.
// The three axes know nothing of each other, so each is one loop over three arrays.
//
// Source: [LRB08] Figure 7, "Advance Particles". The contract stands in common/fluid/advance.h.
#include "common/fluid/advance.h"

#include "common/real.h"

namespace lockstep::fluid::openmp {
namespace {

void leapfrog(const Model<Real>& model, const Axis<Real>& axis, int count, const Array<Real>& acceleration, Array<Real>& position,
              Array<Real>& half_velocity, Array<Real>& velocity) {
  // Iterations are independent: particle i writes its own position and velocities alone.
#pragma omp parallel for simd schedule(static)
  for (int i = 0; i < count; ++i) {
    const int cell = cell_coordinate(axis, position[i]);
    Real hv = half_velocity[i] + acceleration[i] * model.time_step;
    Real p = position[i] + hv * model.time_step;
    Real v = (half_velocity[i] + hv) * Real(.5);

    const bool below = model.walls && cell == 0 && p < axis.min;
    const bool above = model.walls && cell == axis.cells - 1 && p > axis.max;
    p = below ? axis.min + (axis.min - p) : above ? axis.max - (p - axis.max) : p;
    v = below || above ? -v : v;
    hv = below || above ? -hv : hv;

    position[i] = p;
    velocity[i] = v;
    half_velocity[i] = hv;
  }
}

}  // namespace

void advance(const Model<Real>& model, const Grid<Real>& grid, const Vectors<Real>& acceleration, Particles<Real>& particles) {
  Vectors<Real>&p = particles.position, &hv = particles.half_velocity, &v = particles.velocity;
  leapfrog(model, grid.x, particles.count, acceleration.x, p.x, hv.x, v.x);
  leapfrog(model, grid.y, particles.count, acceleration.y, p.y, hv.y, v.y);
  leapfrog(model, grid.z, particles.count, acceleration.z, p.z, hv.z, v.z);
}

}  // namespace lockstep::fluid::openmp
