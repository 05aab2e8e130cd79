// Moves the velocity with itself.
//
// The algorithm and its serial form stand in serial/production_fluid/advect_velocity.cpp. Sixteen faces along x at
// once; threads share the lines. Faces of one line stand side by side, so what stands at them is loaded; what stands at
// a foot is mostly loaded, too (corners.h).
//
// The contract stands in common/production_fluid/advect_velocity.h.
#include "common/production_fluid/advect_velocity.h"

#include "common/real.h"
#include "common/simd.h"
#include "openmp/production_fluid/corners.h"

namespace lockstep::production_fluid::openmp {
namespace {

using Index = intv;

// The velocity at sixteen faces of u, of v and of w. At a side of the box the cell beyond it is missing, and the one
// inside counts twice: along x by a mask, since the cell beyond is padding.
constexpr auto at_u = [](const Faces<Real>& faces, int x, int y, int z) -> Vector3<floatv> {
  const auto& [u, v, w] = faces;
  const intv lane_x = x + lane_index();
  const auto left = [&](const Real* at) { return select(lane_x > 0, load(at - 1), load(at)); };
  const auto right = [&, nx = v.nx](const Real* at) { return select(lane_x < nx, load(at), load(at - 1)); };
  return {load(&u(x, y, z)), mean(left(&v(x, y, z)), left(&v(x, y + 1, z)), right(&v(x, y, z)), right(&v(x, y + 1, z))),
          mean(left(&w(x, y, z)), left(&w(x, y, z + 1)), right(&w(x, y, z)), right(&w(x, y, z + 1)))};
};
constexpr auto at_v = [](const Faces<Real>& faces, int x, int y, int z) -> Vector3<floatv> {
  const auto& [u, v, w] = faces;
  const int low = y > 0 ? y - 1 : y, high = y < u.ny ? y : y - 1;
  return {mean(load(&u(x, low, z)), load(&u(x + 1, low, z)), load(&u(x, high, z)), load(&u(x + 1, high, z))),
          load(&v(x, y, z)),
          mean(load(&w(x, low, z)), load(&w(x, low, z + 1)), load(&w(x, high, z)), load(&w(x, high, z + 1)))};
};
constexpr auto at_w = [](const Faces<Real>& faces, int x, int y, int z) -> Vector3<floatv> {
  const auto& [u, v, w] = faces;
  const int near = z > 0 ? z - 1 : z, far = z < u.nz ? z : z - 1;
  return {mean(load(&u(x, y, near)), load(&u(x + 1, y, near)), load(&u(x, y, far)), load(&u(x + 1, y, far))),
          mean(load(&v(x, y, near)), load(&v(x, y + 1, near)), load(&v(x, y, far)), load(&v(x, y + 1, far))),
          load(&w(x, y, z))};
};

// The components have different numbers of lines.
template <class VelocityAt>
void advect_line(const Faces<Real>& faces, Real cells, const VelocityAt& velocity_at_face, const Field<Real>& component,
                 const Vector3<float>& first, int y, int z, Field<Real>& advected) {
  if (y >= component.ny || z >= component.nz) return;
  for (int begin = 0; begin < component.nx; begin += lanes) {
    const int x = first_of_full(begin, component.nx);
    const intv lane_x = x + lane_index();
    const Vector3<floatv> face = {to_float(lane_x) + first.x, to_float(y) + first.y, to_float(z) + first.z};
    const Vector3<floatv> foot = foot_of<Index>(face, velocity_at_face(faces, x, y, z), faces, cells);
    store(&advected(x, y, z), sample<Index>(component, first, foot), first_lanes(component.nx - x));
  }
}

}  // namespace

void advect_velocity(const Faces<Real>& faces, Real dt, Faces<Real>& advected) {
  const Real cells = dt / faces.u.spacing;
  // A line writes its own faces, from fields that none writes.
#pragma omp parallel for collapse(2) schedule(static)
  for (int z = 0; z < faces.w.nz; ++z)
    for (int y = 0; y < faces.v.ny; ++y) {
      advect_line(faces, cells, at_u, faces.u, first_u, y, z, advected.u);
      advect_line(faces, cells, at_v, faces.v, first_v, y, z, advected.v);
      advect_line(faces, cells, at_w, faces.w, first_w, y, z, advected.w);
    }
}

}  // namespace lockstep::production_fluid::openmp
