// Moves the level set with the velocity.
//
// Each centre asks where its value comes from and interpolates phi there, so values stay between those that were there,
// however long the step. Interpolation smooths: corners of the surface become round, and thin sheets vanish. Particles
// give back what is lost, so the first order of this advection is enough.
//
// The contract stands in common/production_fluid/advect_level_set.h.
#include "common/production_fluid/advect_level_set.h"

#include "common/real.h"

namespace lockstep::production_fluid::serial {
namespace {

using Index = std::int32_t;

Vector3<Real> at_centre(const Faces<Real>& faces, int x, int y, int z) {
  const auto& [u, v, w] = faces;
  return {mean(u(x, y, z), u(x + 1, y, z)), mean(v(x, y, z), v(x, y + 1, z)), mean(w(x, y, z), w(x, y, z + 1))};
}

}  // namespace

void advect_level_set(const Field<Real>& phi, const Faces<Real>& faces, Real dt, Field<Real>& advected) {
  const Real cells = dt / phi.spacing;
  const Vector3<float> first = first_centre;
  for (int z = 0; z < phi.nz; ++z)
    for (int y = 0; y < phi.ny; ++y)
      for (int x = 0; x < phi.nx; ++x) {
        const Vector3<Real> centre = {to_float(x) + first.x, to_float(y) + first.y, to_float(z) + first.z};
        const Vector3<Real> foot = foot_of<Index>(centre, at_centre(faces, x, y, z), faces, cells);
        advected(x, y, z) = sample<Index>(phi, first, foot);
      }
}

}  // namespace lockstep::production_fluid::serial
