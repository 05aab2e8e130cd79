// Finds the longest time step in which nothing moves too far.
//
// The contract stands in common/production_fluid/time_step.h.
#include "common/production_fluid/time_step.h"

#include "common/real.h"

namespace lockstep::production_fluid::serial {

Real time_step(const Faces<Real>& faces, Real gravity, Real cfl) {
  const auto& [u, v, w] = faces;
  Real most = 0;
  for (int z = 0; z < u.nz; ++z)
    for (int y = 0; y < u.ny; ++y)
      for (int x = 0; x < v.nx; ++x)
        most = max(most, speed_of(u(x, y, z), u(x + 1, y, z), v(x, y, z), v(x, y + 1, z), w(x, y, z), w(x, y, z + 1)));
  return time_step_of(most, gravity, cfl, u.spacing);
}

}  // namespace lockstep::production_fluid::serial
