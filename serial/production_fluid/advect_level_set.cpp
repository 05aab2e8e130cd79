// Moves the level set with the velocity.
//
// Each centre asks where its value comes from and interpolates phi there, so values stay between those that were there,
// however long the step. Interpolation smooths: corners of the surface become round, and thin sheets vanish. Particles
// give back what is lost; with them, the first order of semi_lagrangian is enough. Without, maccormack carries smooth
// shapes with second order. Its first pass writes every cell, so the second finds what arrived wherever it looks.
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

// Calls f(x, y, z, foot) for each centre.
template <class F>
void for_each_foot(const Field<Real>& phi, const Faces<Real>& faces, Real dt, const F& f) {
  const Real cells = dt / phi.spacing;
  const Vector3<float> first = first_centre;
  for (int z = 0; z < phi.nz; ++z)
    for (int y = 0; y < phi.ny; ++y)
      for (int x = 0; x < phi.nx; ++x) {
        const Vector3<Real> centre = {to_float(x) + first.x, to_float(y) + first.y, to_float(z) + first.z};
        f(x, y, z, foot_of<Index>(centre, at_centre(faces, x, y, z), faces, cells));
      }
}

}  // namespace

void advect_level_set_semi_lagrangian(const Field<Real>& phi, const Faces<Real>& faces, Real dt,
                                      Field<Real>& advected) {
  for_each_foot(phi, faces, dt, [&](int x, int y, int z, const Vector3<Real>& foot) {
    advected(x, y, z) = sample<Index>(phi, first_centre, foot);
  });
}

void advect_level_set_maccormack(const Field<Real>& phi, const Faces<Real>& faces, Real dt, Field<Real>& advected,
                                 Arrived<Field<Real>>& arrived) {
  for_each_foot(phi, faces, dt, [&](int x, int y, int z, const Vector3<Real>& foot) {
    const Bounded<Real> at = sample_bounded<Index>(phi, first_centre, foot);
    arrived.value(x, y, z) = at.value;
    arrived.least(x, y, z) = at.least;
    arrived.most(x, y, z) = at.most;
  });
  for_each_foot(phi, faces, -dt, [&](int x, int y, int z, const Vector3<Real>& back) {
    const Bounded<Real> at = {arrived.value(x, y, z), arrived.least(x, y, z), arrived.most(x, y, z)};
    advected(x, y, z) = corrected<Index>(phi(x, y, z), at, arrived.value, first_centre, back);
  });
}

}  // namespace lockstep::production_fluid::serial
