// Lets the particles' balls touch the surface again: sixteen particles at once, wherever they are; threads share them
// out evenly.
//
// The contract stands in common/production_fluid/adjust_radii.h.
#include "common/production_fluid/adjust_radii.h"

#include "common/production_fluid/trace.h"
#include "common/real.h"
#include "common/simd.h"
#include "openmp/production_fluid/line_corners.h"

namespace lockstep::production_fluid::openmp {

void adjust_radii(const Field<Real>& phi, Particles<Real>& particles) {
  const auto& [px, py, pz] = particles.position;
  const Real *const x = px.data(), *const y = py.data(), *const z = pz.data();
  const int count = particles.count;
  // A particle is one iteration's; all read the same field.
#pragma omp parallel for schedule(static)
  for (int i = 0; i < count; i += lanes) {
    const Vector3<floatv> at = floatv(1 / phi.spacing) * Vector3<floatv>{load(x + i), load(y + i), load(z + i)};
    const floatv here = sample<intv>(phi, first_centre, at, LineCorners());
    store(&particles.radius[i], radius_of(load(&particles.sign[i]), here, floatv(phi.spacing)), first_lanes(count - i));
  }
}

}  // namespace lockstep::production_fluid::openmp
