// Moves the level set with the velocity.
//
// The algorithm and its serial form stand in serial/production_fluid/advect_level_set.cpp. Sixteen cells along x at
// once; threads share the lines. What stands at a foot is mostly loaded, not gathered (corners.h).
//
// The contract stands in common/production_fluid/advect_level_set.h.
#include "common/production_fluid/advect_level_set.h"

#include "common/real.h"
#include "common/simd.h"
#include "openmp/production_fluid/corners.h"

namespace lockstep::production_fluid::openmp {
namespace {

using Index = intv;

Vector3<floatv> at_centre(const Faces<Real>& faces, int x, int y, int z) {
  const auto& [u, v, w] = faces;
  return {mean(load(&u(x, y, z)), load(&u(x + 1, y, z))), mean(load(&v(x, y, z)), load(&v(x, y + 1, z))),
          mean(load(&w(x, y, z)), load(&w(x, y, z + 1)))};
}

}  // namespace

void advect_level_set(const Field<Real>& phi, const Faces<Real>& faces, Real dt, Field<Real>& advected) {
  const Real cells = dt / phi.spacing;
  const Vector3<float> first = first_centre;
  // A line writes its own cells, from fields that none writes.
#pragma omp parallel for collapse(2) schedule(static)
  for (int z = 0; z < phi.nz; ++z)
    for (int y = 0; y < phi.ny; ++y)
      for (int begin = 0; begin < phi.nx; begin += lanes) {
        const int x = first_of_full(begin, phi.nx);
        const intv lane_x = x + lane_index();
        const Vector3<floatv> centre = {to_float(lane_x) + first.x, to_float(y) + first.y, to_float(z) + first.z};
        const Vector3<floatv> foot = foot_of<Index>(centre, at_centre(faces, x, y, z), faces, cells);
        store(&advected(x, y, z), sample<Index>(phi, first, foot), first_lanes(phi.nx - x));
      }
}

}  // namespace lockstep::production_fluid::openmp
