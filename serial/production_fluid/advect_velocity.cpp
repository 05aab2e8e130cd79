// Moves the velocity with itself.
//
// A value is not pushed forward to where it goes; each face asks where its value comes from. So every face gets exactly
// one value, and none exceeds the largest that was there, however long the step. The faces of the three components
// differ in where they stand and in which neighbours give the other two components; the rest is one text.
//
// The contract stands in common/production_fluid/advect_velocity.h.
#include "common/production_fluid/advect_velocity.h"

#include "common/real.h"

namespace lockstep::production_fluid::serial {
namespace {

using Index = std::int32_t;

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

template <class VelocityAt>
void advect(const Faces<Real>& faces, Real cells, const VelocityAt& velocity_at_face, const Field<Real>& component,
            const Vector3<float>& first, Field<Real>& advected) {
  for (int z = 0; z < component.nz; ++z)
    for (int y = 0; y < component.ny; ++y)
      for (int x = 0; x < component.nx; ++x) {
        const Vector3<Real> face = {to_float(x) + first.x, to_float(y) + first.y, to_float(z) + first.z};
        const Vector3<Real> foot = foot_of<Index>(face, velocity_at_face(faces, x, y, z), faces, cells);
        advected(x, y, z) = sample<Index>(component, first, foot);
      }
}

}  // namespace

void advect_velocity(const Faces<Real>& faces, Real dt, Faces<Real>& advected) {
  const Real cells = dt / faces.u.spacing;
  advect(faces, cells, at_u, faces.u, first_u, advected.u);
  advect(faces, cells, at_v, faces.v, first_v, advected.v);
  advect(faces, cells, at_w, faces.w, first_w, advected.w);
}

}  // namespace lockstep::production_fluid::serial
