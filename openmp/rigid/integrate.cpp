// Moves bodies by one step with the velocities that the solver found.
//
// Semi-implicit Euler: positions move with the new velocities, which bounds the energy of a fall. Only the rotation
// needs care: see common/rigid/spin.h. Sixteen bodies move at once: their records are loaded whole and transposed into
// lanes.
//
// The contract stands in common/rigid/integrate.h.
#include "common/rigid/integrate.h"

#include "common/real.h"
#include "common/rigid/spin.h"
#include "common/simd.h"
#include "openmp/rigid/lanes.h"

namespace lockstep::rigid::openmp {

void integrate(std::span<const Motion<Real>> moving, Real dt, Bodies<Real>& bodies) {
  // Each body belongs to one thread. The last vector reads padding and does not write it.
#pragma omp parallel for schedule(static)
  for (int i = 0; i < bodies.count; i += lanes) {
    const Indices index = sixteen(i);
    const Quad<floatv> inverse_mass = load_quad(bodies.inverse_mass, index);
    const maskv moves = first_lanes(bodies.count - i) & (inverse_mass.w > 0.f);
    if (none(moves)) continue;
    Pose<floatv> pose = load_pose(bodies.pose, index);
    Motion<floatv> motion = load_motion(bodies.motion, index);
    advance<floatv>(inverse_mass, load_motion(moving, index), dt, pose, motion);
    store_pose(bodies.pose, index, pose, moves);
    store_motion(bodies.motion, index, motion, moves);
  }
}

}  // namespace lockstep::rigid::openmp
