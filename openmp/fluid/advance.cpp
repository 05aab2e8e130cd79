// One leapfrog step; particles that went through a wall are mirrored at it.
//
// Velocities at half steps move positions at whole steps: the cost of Euler's method, and second order. The axes are
// independent of each other, so each is one loop over three arrays.
//
// Source: [LRB08] Figure 7, "Advance Particles". The contract stands in common/fluid/advance.h.
#include "common/fluid/advance.h"

#include "common/fluid/motion.h"
#include "common/real.h"

namespace lockstep::fluid::openmp {
namespace {

// This thread's share of one axis; it is called by all threads of a region. The model and the axis are copies, so that
// a compiler knows that no store into an array changes them.
void advance_axis(Model<Real> model, Axis<Real> axis, int count, const Array<Real>& acceleration, Array<Real>& position,
                  Array<Real>& half_velocity, Array<Real>& velocity) {
  // Iterations are independent: particle i writes its own position and velocities alone, and those of other axes are
  // other arrays: no loop waits for another.
#pragma omp for simd schedule(static) nowait
  for (int i = 0; i < count; ++i) {
    const Movement<Real> moved = leapfrog(model, axis, acceleration[i], position[i], half_velocity[i]);
    position[i] = moved.position, half_velocity[i] = moved.half_velocity, velocity[i] = moved.velocity;
  }
}

}  // namespace

void advance(const Model<Real>& model, const Grid<Real>& grid, const Vectors<Real>& acceleration,
             Particles<Real>& particles) {
  Vectors<Real>&p = particles.position, &hv = particles.half_velocity, &v = particles.velocity;
  // One region for the three axes; see advance_axis.
#pragma omp parallel
  {
    advance_axis(model, grid.x, particles.count, acceleration.x, p.x, hv.x, v.x);
    advance_axis(model, grid.y, particles.count, acceleration.y, p.y, hv.y, v.y);
    advance_axis(model, grid.z, particles.count, acceleration.z, p.z, hv.z, v.z);
  }
}

}  // namespace lockstep::fluid::openmp
