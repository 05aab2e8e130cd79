// Moves the velocity with itself.
//
// A value is not pushed forward to where it goes; each face asks where its value comes from. So every face gets exactly
// one value, and none exceeds the largest that was there, however long the step. The faces of the three components
// differ in where they stand and in which neighbours give the other two components; the rest is one text. The lines of
// the three components at one place are advected one after another, so that each is brought from memory once.
//
// maccormack goes through the faces twice. Its first pass writes every face, so the second finds what arrived
// wherever it looks.
//
// The contract stands in common/production_fluid/advect_velocity.h.
#include "common/production_fluid/advect_velocity.h"

#include "common/real.h"

namespace lockstep::production_fluid::serial {
namespace {

using Index = std::int32_t;
using Component = Field<Real> Faces<Real>::*;

// The velocity at a face of u, of v and of w. At a side of the box the cell beyond it is missing, and the one inside
// counts twice.
constexpr auto at_u = [](const Faces<Real>& faces, int x, int y, int z) -> Vector3<Real> {
  const auto& [u, v, w] = faces;
  const int left = x > 0 ? x - 1 : x, right = x < v.nx ? x : x - 1;
  return {u(x, y, z), mean(v(left, y, z), v(left, y + 1, z), v(right, y, z), v(right, y + 1, z)),
          mean(w(left, y, z), w(left, y, z + 1), w(right, y, z), w(right, y, z + 1))};
};
constexpr auto at_v = [](const Faces<Real>& faces, int x, int y, int z) -> Vector3<Real> {
  const auto& [u, v, w] = faces;
  const int low = y > 0 ? y - 1 : y, high = y < u.ny ? y : y - 1;
  return {mean(u(x, low, z), u(x + 1, low, z), u(x, high, z), u(x + 1, high, z)), v(x, y, z),
          mean(w(x, low, z), w(x, low, z + 1), w(x, high, z), w(x, high, z + 1))};
};
constexpr auto at_w = [](const Faces<Real>& faces, int x, int y, int z) -> Vector3<Real> {
  const auto& [u, v, w] = faces;
  const int near = z > 0 ? z - 1 : z, far = z < u.nz ? z : z - 1;
  return {mean(u(x, y, near), u(x + 1, y, near), u(x, y, far), u(x + 1, y, far)),
          mean(v(x, y, near), v(x, y + 1, near), v(x, y, far), v(x, y + 1, far)), w(x, y, z)};
};

// Calls f(component, first, x, y, z, foot) for each face of a line. The components have different numbers of lines.
template <class VelocityAt, class F>
void for_each_foot_of_line(const Faces<Real>& faces, Real cells, const VelocityAt& velocity_at_face,
                           Component component, const Vector3<float>& first, int y, int z, const F& f) {
  const int nx = (faces.*component).nx, ny = (faces.*component).ny, nz = (faces.*component).nz;
  if (y >= ny || z >= nz) return;
  for (int x = 0; x < nx; ++x) {
    const Vector3<Real> face = {to_float(x) + first.x, to_float(y) + first.y, to_float(z) + first.z};
    f(component, first, x, y, z, foot_of<Index>(face, velocity_at_face(faces, x, y, z), faces, cells));
  }
}

template <class F>
void for_each_foot(const Faces<Real>& faces, Real dt, const F& f) {
  const Real cells = dt / faces.u.spacing;
  for (int z = 0; z < faces.w.nz; ++z)
    for (int y = 0; y < faces.v.ny; ++y) {
      for_each_foot_of_line(faces, cells, at_u, &Faces<Real>::u, first_u, y, z, f);
      for_each_foot_of_line(faces, cells, at_v, &Faces<Real>::v, first_v, y, z, f);
      for_each_foot_of_line(faces, cells, at_w, &Faces<Real>::w, first_w, y, z, f);
    }
}

}  // namespace

void advect_velocity_semi_lagrangian(const Faces<Real>& faces, Real dt, Faces<Real>& advected) {
  for_each_foot(faces, dt, [&](Component c, Vector3<float> first, int x, int y, int z, const Vector3<Real>& foot) {
    (advected.*c)(x, y, z) = sample<Index>(faces.*c, first, foot);
  });
}

void advect_velocity_maccormack(const Faces<Real>& faces, Real dt, Faces<Real>& advected,
                                Arrived<Faces<Real>>& arrived) {
  for_each_foot(faces, dt, [&](Component c, Vector3<float> first, int x, int y, int z, const Vector3<Real>& foot) {
    const Bounded<Real> at = sample_bounded<Index>(faces.*c, first, foot);
    (arrived.value.*c)(x, y, z) = at.value;
    (arrived.least.*c)(x, y, z) = at.least;
    (arrived.most.*c)(x, y, z) = at.most;
  });
  for_each_foot(faces, -dt, [&](Component c, Vector3<float> first, int x, int y, int z, const Vector3<Real>& back) {
    const Bounded<Real> at = {(arrived.value.*c)(x, y, z), (arrived.least.*c)(x, y, z), (arrived.most.*c)(x, y, z)};
    (advected.*c)(x, y, z) = corrected<Index>((faces.*c)(x, y, z), at, arrived.value.*c, first, back);
  });
}

}  // namespace lockstep::production_fluid::serial
