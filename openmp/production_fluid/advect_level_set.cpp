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

// Calls f(x, y, z, foot) for sixteen centres at a time.
template <class F>
void for_each_foot(const Field<Real>& phi, const Faces<Real>& faces, Real dt, const F& f) {
  const Real cells = dt / phi.spacing;
  const Vector3<float> first = first_centre;
  // A line writes its own cells, in fields that none reads.
#pragma omp parallel for collapse(2) schedule(static)
  for (int z = 0; z < phi.nz; ++z)
    for (int y = 0; y < phi.ny; ++y)
      for (int begin = 0; begin < phi.nx; begin += lanes) {
        const int x = first_of_full(begin, phi.nx);
        const intv lane_x = x + lane_index();
        const Vector3<floatv> centre = {to_float(lane_x) + first.x, to_float(y) + first.y, to_float(z) + first.z};
        f(x, y, z, foot_of<Index>(centre, at_centre(faces, x, y, z), faces, cells));
      }
}

}  // namespace

void advect_level_set_semi_lagrangian(const Field<Real>& phi, const Faces<Real>& faces, Real dt,
                                      Field<Real>& advected) {
  for_each_foot(phi, faces, dt, [&](int x, int y, int z, const Vector3<floatv>& foot) {
    store(&advected(x, y, z), sample<Index>(phi, first_centre, foot), first_lanes(phi.nx - x));
  });
}

void advect_level_set_maccormack(const Field<Real>& phi, const Faces<Real>& faces, Real dt, Field<Real>& advected,
                                 Arrived<Field<Real>>& arrived) {
  for_each_foot(phi, faces, dt, [&](int x, int y, int z, const Vector3<floatv>& foot) {
    const Bounded<floatv> at = sample_bounded<Index>(phi, first_centre, foot);
    const maskv inside = first_lanes(phi.nx - x);
    store(&arrived.value(x, y, z), at.value, inside);
    store(&arrived.least(x, y, z), at.least, inside);
    store(&arrived.most(x, y, z), at.most, inside);
  });
  for_each_foot(phi, faces, -dt, [&](int x, int y, int z, const Vector3<floatv>& back) {
    const Bounded<floatv> at = {load(&arrived.value(x, y, z)), load(&arrived.least(x, y, z)),
                                load(&arrived.most(x, y, z))};
    const floatv better = corrected<Index>(load(&phi(x, y, z)), at, arrived.value, first_centre, back);
    store(&advected(x, y, z), better, first_lanes(phi.nx - x));
  });
}

}  // namespace lockstep::production_fluid::openmp
