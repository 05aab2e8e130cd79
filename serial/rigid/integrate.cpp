// Moves bodies by one step with the velocities that the solver found.
//
// Semi-implicit Euler: positions move with the new velocities, which bounds the energy of a fall. Only the rotation
// needs care: see common/rigid/spin.h.
//
// The contract stands in common/rigid/integrate.h.
#include "common/rigid/integrate.h"

#include "common/math.h"
#include "common/real.h"
#include "common/rigid/spin.h"

namespace lockstep::rigid::serial {

void integrate(std::span<const Motion<Real>> moving, Real dt, Bodies<Real>& bodies) {
  for (int i = 0; i < bodies.count; ++i) {
    const Quad<Real>& inverse_mass = bodies.inverse_mass[i];
    const bool moves = inverse_mass.w > 0;
    if (none(moves)) continue;
    advance(inverse_mass, moving[i], dt, bodies.pose[i], bodies.motion[i]);
  }
}

}  // namespace lockstep::rigid::serial
