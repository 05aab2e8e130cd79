// Lets the particles' balls touch the surface again. The surface moved on the grid, the particles by themselves.
//
// The contract stands in common/production_fluid/adjust_radii.h.
#include "common/production_fluid/adjust_radii.h"

#include "common/production_fluid/trace.h"
#include "common/real.h"

namespace lockstep::production_fluid::serial {

void adjust_radii(const Field<Real>& phi, Particles<Real>& particles) {
  for (int i = 0; i < particles.count; ++i) {
    const Vector3<Real> at = (1 / phi.spacing) * load(particles.position, i);
    const Real here = sample<std::int32_t>(phi, first_centre, at);
    particles.radius[i] = radius_of(particles.sign[i], here, phi.spacing);
  }
}

}  // namespace lockstep::production_fluid::serial
