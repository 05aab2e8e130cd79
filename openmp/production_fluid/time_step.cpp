// Finds the longest time step in which nothing moves too far: sixteen cells along x at once; threads share the lines.
//
// The contract stands in common/production_fluid/time_step.h.
#include "common/production_fluid/time_step.h"

#include "common/real.h"
#include "common/simd.h"

namespace lockstep::production_fluid::openmp {

Real time_step(const Faces<Real>& faces, Real gravity, Real cfl) {
  const Field<Real>&u = faces.u, &v = faces.v, &w = faces.w;
  Real most = 0;
  // Faces are only read; each thread has its own greatest, and the greatest of these is the same in any order.
#pragma omp parallel for collapse(2) schedule(static) reduction(max : most)
  for (int z = 0; z < u.nz; ++z)
    for (int y = 0; y < u.ny; ++y) {
      floatv of_line = 0;
      for (int x = 0; x < v.nx; x += lanes) {
        const floatv speed = speed_of(load(&u(x, y, z)), load(&u(x + 1, y, z)), load(&v(x, y, z)),
                                      load(&v(x, y + 1, z)), load(&w(x, y, z)), load(&w(x, y, z + 1)));
        where(first_lanes(v.nx - x), of_line) = max(of_line, speed);
      }
      most = max(most, reduce_max(of_line));
    }
  return time_step_of(most, gravity, cfl, u.spacing);
}

}  // namespace lockstep::production_fluid::openmp
