// Lets escaped particles put the level set right.
//
// Advection on a grid rounds off corners and loses thin sheets. Particles do not get lost: one that is found on the
// wrong side shows that the surface should pass beyond it. It rebuilds its own piece, the ball around it.
//
// The contract stands in common/production_fluid/correct_level_set.h.
#include "common/production_fluid/correct_level_set.h"

#include <algorithm>

#include "common/real.h"

namespace lockstep::production_fluid::serial {
namespace {

using Index = std::int32_t;

// The eight centres around a position.
template <class F>
void for_each_centre(const Field<Real>& phi, const Vector3<Real>& at, const F& f) {
  const auto first = [](Real x, int n) { return place<Index>(x - Real(.5), n).first; };
  const Index x = first(at.x, phi.nx), y = first(at.y, phi.ny), z = first(at.z, phi.nz);
  for (int cz = z; cz < std::min(z + 2, phi.nz); ++cz)
    for (int cy = y; cy < std::min(y + 2, phi.ny); ++cy)
      for (int cx = x; cx < std::min(x + 2, phi.nx); ++cx) f(cx, cy, cz);
}

}  // namespace

void correct_level_set(const Particles<Real>& particles, Field<Real>& phi) {
  Field<Real> plus = phi, minus = phi;
  for (int i = 0; i < particles.count; ++i) {
    const Real sign = particles.sign[i], radius = particles.radius[i];
    const Vector3<Real> at = (1 / phi.spacing) * load(particles.position, i);
    if (!has_escaped(sign, sample<Index>(phi, first_centre, at), radius)) continue;
    for_each_centre(phi, at, [&](int x, int y, int z) {
      const Vector3<Real> centre = {to_float(x) + Real(.5), to_float(y) + Real(.5), to_float(z) + Real(.5)};
      const Real level = level_of_ball(sign, radius, centre - at, phi.spacing);
      correct_centre(sign, level, plus(x, y, z), minus(x, y, z));
    });
  }
  for (int z = 0; z < phi.nz; ++z)
    for (int y = 0; y < phi.ny; ++y)
      for (int x = 0; x < phi.nx; ++x) phi(x, y, z) = of_less_magnitude(plus(x, y, z), minus(x, y, z));
}

}  // namespace lockstep::production_fluid::serial
