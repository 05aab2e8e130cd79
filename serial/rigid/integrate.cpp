// Bodies moved by a step: positions and orientations by velocities.
//
// Semi-implicit Euler: positions move with the new velocities, which keeps the energy of a fall bounded. The turning of a body is the one
// thing that is not plain: see common/rigid/spin.h.
//
// The contract stands in common/rigid/integrate.h.
#include "common/rigid/integrate.h"

#include "common/math.h"
#include "common/real.h"
#include "common/rigid/spin.h"

namespace lockstep::rigid::serial {

void advance_bodies(std::span<const Motion<Real>> moving, Real dt, Bodies<Real>& bodies) {
  for (int i = 0; i < bodies.count; ++i) {
    const Quad<Real>& inverse_mass = bodies.inverse_mass[i];
    if (!(inverse_mass.w > 0)) continue;
    Pose<Real>& pose = bodies.pose[i];
    Vector3<Real>& angular_velocity = bodies.motion[i].angular_velocity;
    const Vector3<Real> inverse = {inverse_mass.x, inverse_mass.y, inverse_mass.z};

    pose.position = pose.position + dt * moving[i].velocity;
    const Vector3<Real> kept = momentum_of_velocity(pose.orientation, inverse, angular_velocity);
    const Vector3<Real> turning = momentum_of_velocity(pose.orientation, inverse, moving[i].angular_velocity);
    const Quaternion<Real> middle = turned_by(Real(.5) * dt * moving[i].angular_velocity, pose.orientation);
    pose.orientation = turned_by(dt * velocity_of_momentum(middle, inverse, turning), pose.orientation);
    angular_velocity = velocity_keeping_momentum(pose.orientation, inverse, kept);
  }
}

}  // namespace lockstep::rigid::serial
