// Drops of spray fly for one step; those that reach the liquid become particles again.
//
// Drop by drop: it moves, and stops where it touches an obstacle or a side. Then it is deleted, becomes a particle, or
// flies on.
//
// The contract stands in common/production_fluid/advance_spray.h.
#include "common/production_fluid/advance_spray.h"

#include "common/real.h"

namespace lockstep::production_fluid::serial {
namespace {

using Index = std::int32_t;

Vector3<Real> in_cells(const Fluid<Real>& fluid, const Vector3<Real>& position) {
  return (1 / fluid.spacing) * position;
}

// Moves a drop out of obstacles and into the box, and stops it there.
void stop(const Fluid<Real>& fluid, const Real& radius, Drop<Real>& drop) {
  const Field<Real>& field = fluid.solid;
  const auto [cell, along] = spot_of<Index>(field, first_centre, in_cells(fluid, drop.position));
  const Corners<Real> corners = load_corners(&field.value[field.index(0, 0, 0)], cell);
  const Real solid = interpolate(corners, along.x, along.y, along.z);
  if (solid < radius) drop = stopped_by_obstacle(drop, radius, solid, slope(corners, along.x, along.y, along.z));
  stop_at_sides(fluid, radius, drop);
}

void move(const Drop<Real>& drop, Real radius, Spray<Real>& to, int k) {
  store(to.position, k, drop.position), store(to.velocity, k, drop.velocity);
  to.radius[k] = radius;
}

void move(const Drop<Real>& drop, Real radius, Particles<Real>& to, int k) {
  store(to.position, k, drop.position);
  to.radius[k] = radius, to.sign[k] = -1;
}

}  // namespace

void advance_spray(const Fluid<Real>& fluid, const Vector3<Real>& gravity, Real dt, Spray<Real>& spray,
                   Particles<Real>& particles) {
  int flying = 0;
  for (int i = 0; i < spray.count; ++i) {
    Drop<Real> drop = flown(Drop<Real>{load(spray.position, i), load(spray.velocity, i)}, gravity, dt);
    if (has_left(fluid, drop)) continue;
    const Real radius = spray.radius[i];
    stop(fluid, radius, drop);
    if (sample<Index>(fluid.phi, first_centre, in_cells(fluid, drop.position)) > radius) {
      move(drop, radius, spray, flying++);
    } else {
      resize(particles, particles.count + 1);
      move(drop, radius, particles, particles.count - 1);
    }
  }
  resize(spray, flying);
}

}  // namespace lockstep::production_fluid::serial
