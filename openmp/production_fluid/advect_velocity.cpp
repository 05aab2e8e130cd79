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
using Component = Field<Real> Faces<Real>::*;

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

// Calls f(component, first, x, y, z, foot) for sixteen faces of a line at a time. The components have different numbers
// of lines.
template <class VelocityAt, class F>
void for_each_foot_of_line(const Faces<Real>& faces, Real cells, const VelocityAt& velocity_at_face,
                           Component component, const Vector3<float>& first, int y, int z, const F& f) {
  const int nx = (faces.*component).nx, ny = (faces.*component).ny, nz = (faces.*component).nz;
  if (y >= ny || z >= nz) return;
  for (int begin = 0; begin < nx; begin += lanes) {
    const int x = first_of_full(begin, nx);
    const intv lane_x = x + lane_index();
    const Vector3<floatv> face = {to_float(lane_x) + first.x, to_float(y) + first.y, to_float(z) + first.z};
    f(component, first, x, y, z, foot_of<Index>(face, velocity_at_face(faces, x, y, z), faces, cells));
  }
}

template <class F>
void for_each_foot(const Faces<Real>& faces, Real dt, const F& f) {
  const Real cells = dt / faces.u.spacing;
  // A line writes its own faces, in fields that none reads.
#pragma omp parallel for collapse(2) schedule(static)
  for (int z = 0; z < faces.w.nz; ++z)
    for (int y = 0; y < faces.v.ny; ++y) {
      for_each_foot_of_line(faces, cells, at_u, &Faces<Real>::u, first_u, y, z, f);
      for_each_foot_of_line(faces, cells, at_v, &Faces<Real>::v, first_v, y, z, f);
      for_each_foot_of_line(faces, cells, at_w, &Faces<Real>::w, first_w, y, z, f);
    }
}

}  // namespace

void advect_velocity_semi_lagrangian(const Faces<Real>& faces, Real dt, Faces<Real>& advected) {
  for_each_foot(faces, dt, [&](Component c, Vector3<float> first, int x, int y, int z, const Vector3<floatv>& foot) {
    const maskv inside = first_lanes((faces.*c).nx - x);
    store(&(advected.*c)(x, y, z), sample<Index>(faces.*c, first, foot), inside);
  });
}

void advect_velocity_maccormack(const Faces<Real>& faces, Real dt, Faces<Real>& advected,
                                Arrived<Faces<Real>>& arrived) {
  for_each_foot(faces, dt, [&](Component c, Vector3<float> first, int x, int y, int z, const Vector3<floatv>& foot) {
    const Bounded<floatv> at = sample_bounded<Index>(faces.*c, first, foot);
    const maskv inside = first_lanes((faces.*c).nx - x);
    store(&(arrived.value.*c)(x, y, z), at.value, inside);
    store(&(arrived.least.*c)(x, y, z), at.least, inside);
    store(&(arrived.most.*c)(x, y, z), at.most, inside);
  });
  for_each_foot(faces, -dt, [&](Component c, Vector3<float> first, int x, int y, int z, const Vector3<floatv>& back) {
    const Bounded<floatv> at = {load(&(arrived.value.*c)(x, y, z)), load(&(arrived.least.*c)(x, y, z)),
                                load(&(arrived.most.*c)(x, y, z))};
    const floatv better = corrected<Index>(load(&(faces.*c)(x, y, z)), at, arrived.value.*c, first, back);
    store(&(advected.*c)(x, y, z), better, first_lanes((faces.*c).nx - x));
  });
}

}  // namespace lockstep::production_fluid::openmp
