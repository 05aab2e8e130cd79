// Moves the particles with the liquid.
//
// Sixteen particles at once, wherever they are; threads share them out evenly. Obstacles are looked at only where one
// is near one of the sixteen.
//
// The contract stands in common/production_fluid/advect_particles.h.
#include "common/production_fluid/advect_particles.h"

#include "common/real.h"
#include "common/simd.h"
#include "openmp/production_fluid/line_corners.h"
#include "openmp/production_fluid/scattered_corners.h"

namespace lockstep::production_fluid::openmp {
namespace {

using Index = intv;

Vector3<floatv> moved(const Vector3<floatv>& p, const Faces<Real>& faces, Real dt) {
  const Real per_spacing = 1 / faces.u.spacing;
  const LineCorners load;
  const Vector3<floatv> at = floatv(per_spacing) * p, velocity = velocity_at<Index>(faces, at, load);
  const Vector3<floatv> ahead = at + floatv(dt * per_spacing) * velocity;
  return p + floatv(Real(.5) * dt) * (velocity + velocity_at<Index>(faces, ahead, load));
}

Vector3<floatv> pushed_out(const Vector3<floatv>& p, const Field<Real>& solid, Real margin) {
  const Spot<floatv, Index> spot = spot_of<Index>(solid, first_centre, floatv(1 / solid.spacing) * p);
  const Real* const values = &solid.value[solid.index(0, 0, 0)];
  const maskv far = gather(values, spot.cell.first) > floatv(Real(far_from_obstacles) * solid.spacing);
  if (all(far)) return p;
  const Corners<floatv> corners = ScatteredCorners()(values, spot.cell);
  const auto& [x, y, z] = spot.along;
  const Vector3<floatv> push = push_out(interpolate(corners, x, y, z), floatv(margin), slope(corners, x, y, z));
  return select(far, p, p + push);
}

}  // namespace

void advect_particles(const Fluid<Real>& fluid, const Faces<Real>& faces, Real dt, Particles<Real>& particles) {
  const Real margin = Real(least_radius) * fluid.spacing;
  auto& [px, py, pz] = particles.position;
  Real *const x = px.data(), *const y = py.data(), *const z = pz.data();
  const int count = particles.count;
  // A particle is one iteration's; all read the same fields.
#pragma omp parallel for schedule(static)
  for (int i = 0; i < count; i += lanes) {
    const Vector3<floatv> from = {load(x + i), load(y + i), load(z + i)};
    const Vector3<floatv> p = kept_in_box(moved(from, faces, dt), fluid, margin);
    const Vector3<floatv> to = kept_in_box(pushed_out(p, fluid.solid, margin), fluid, margin);
    const maskv there = first_lanes(count - i);
    store(x + i, to.x, there), store(y + i, to.y, there), store(z + i, to.z, there);
  }
}

}  // namespace lockstep::production_fluid::openmp
