// Moves the particles with the liquid.
//
// A particle keeps what interpolation on a grid loses, because it is moved itself: nothing is averaged. So its way is
// computed to second order, by the velocity where it is and that where it gets to.
//
// The contract stands in common/production_fluid/advect_particles.h.
#include "common/production_fluid/advect_particles.h"

#include "common/real.h"

namespace lockstep::production_fluid::serial {
namespace {

using Index = std::int32_t;

Vector3<Real> moved(const Vector3<Real>& p, const Faces<Real>& faces, Real dt) {
  const Real per_spacing = 1 / faces.u.spacing;
  const Vector3<Real> at = per_spacing * p, velocity = velocity_at<Index>(faces, at);
  const Vector3<Real> ahead = at + (dt * per_spacing) * velocity;
  return p + (Real(.5) * dt) * (velocity + velocity_at<Index>(faces, ahead));
}

Vector3<Real> pushed_out(const Vector3<Real>& p, const Field<Real>& solid, Real margin) {
  const Spot<Real, Index> spot = spot_of<Index>(solid, first_centre, (1 / solid.spacing) * p);
  const Real* const values = &solid.value[solid.index(0, 0, 0)];
  if (values[spot.cell.first] > Real(far_from_obstacles) * solid.spacing) return p;
  const Corners<Real> corners = load_corners(values, spot.cell);
  const auto& [x, y, z] = spot.along;
  return p + push_out(interpolate(corners, x, y, z), margin, slope(corners, x, y, z));
}

}  // namespace

void advect_particles(const Fluid<Real>& fluid, const Faces<Real>& faces, Real dt, Particles<Real>& particles) {
  const Real margin = Real(least_radius) * fluid.spacing;
  for (int i = 0; i < particles.count; ++i) {
    const Vector3<Real> p = kept_in_box(moved(load(particles.position, i), faces, dt), fluid, margin);
    store(particles.position, i, kept_in_box(pushed_out(p, fluid.solid, margin), fluid, margin));
  }
}

}  // namespace lockstep::production_fluid::serial
