// Bodies moved by a step: positions and orientations by velocities.
//
// Semi-implicit Euler: positions move with the new velocities, which keeps the energy of a fall bounded. The turning of a body is the one
// thing that is not plain: see common/rigid/spin.h. Sixteen bodies at once, whose records are loaded whole and change places with lanes.
//
// The contract stands in common/rigid/integrate.h.
#include "common/rigid/integrate.h"

#include "common/real.h"
#include "common/rigid/spin.h"
#include "common/simd.h"

namespace lockstep::rigid::openmp {
namespace {

// Bodies i .. i + 15.
struct Sixteen {
  std::int32_t index[lanes];
  explicit Sixteen(int i) { store(index, lane_index() + i); }
};

}  // namespace

void advance_bodies(std::span<const Motion<Real>> moving, Real dt, Bodies<Real>& bodies) {
  // Every body is one thread's. The last vector reads padding, and writes none.
#pragma omp parallel for schedule(static)
  for (int i = 0; i < bodies.count; i += lanes) {
    const Sixteen body(i);
    const Quads inverse_mass = load_quads(&bodies.inverse_mass.data()->x, body.index);
    const maskv moves = first_lanes(bodies.count - i) & (inverse_mass.field[3] > 0.f);
    if (none(moves)) continue;
    Records pose = load_records(&bodies.pose.data()->position.x, body.index);
    Records motion = load_records(&bodies.motion.data()->velocity.x, body.index);
    const Records by = load_records(&moving.data()->velocity.x, body.index);
    const Vector3<floatv> inverse = {inverse_mass.field[0], inverse_mass.field[1], inverse_mass.field[2]};
    const Quaternion<floatv> orientation = {pose.field[3], pose.field[4], pose.field[5], pose.field[6]};
    const Vector3<floatv> turning_by = {by.field[3], by.field[4], by.field[5]};

    for (int axis = 0; axis < 3; ++axis) pose.field[axis] += dt * by.field[axis];
    const Vector3<floatv> kept = momentum_of_velocity(orientation, inverse, {motion.field[3], motion.field[4], motion.field[5]});
    const Vector3<floatv> turning = momentum_of_velocity(orientation, inverse, turning_by);
    const Quaternion<floatv> middle = turned_by(floatv(Real(.5) * dt) * turning_by, orientation);
    const Quaternion<floatv> turned = turned_by(floatv(dt) * velocity_of_momentum(middle, inverse, turning), orientation);
    const Vector3<floatv> angular_velocity = velocity_keeping_momentum(turned, inverse, kept);

    pose.field[3] = turned.x, pose.field[4] = turned.y, pose.field[5] = turned.z, pose.field[6] = turned.w;
    motion.field[3] = angular_velocity.x, motion.field[4] = angular_velocity.y, motion.field[5] = angular_velocity.z;
    store_records(&bodies.pose.data()->position.x, body.index, pose, moves);
    store_records(&bodies.motion.data()->velocity.x, body.index, motion, moves);
  }
}

}  // namespace lockstep::rigid::openmp
