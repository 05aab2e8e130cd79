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

#include <initializer_list>

#include "common/real.h"
#include "serial/production_fluid/bricks.h"

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

// The bricks whose faces must be traced. In the others and beside them all velocities are 0, and the faces of
// `advected` get 0.
Bricks bricks_to_trace(const Faces<Real>& faces, std::initializer_list<Faces<Real>*> advected) {
  Bricks bricks(faces.v.nx, faces.u.ny, faces.u.nz);
  const auto is_zero = [](const Real& speed) { return speed == 0; };
  for (int row = 0; row < bricks.rows(); ++row)
    for (int k = 0; k < bricks.along_x(); ++k) {
      const Box brick = bricks.brick(row, k), near = around(brick);
      if (!all_in(faces.u, near, is_zero) || !all_in(faces.v, near, is_zero) || !all_in(faces.w, near, is_zero))
        continue;
      bricks.settle(row, k);
      for (Faces<Real>* to : advected)
        for (Field<Real>* component : {&to->u, &to->v, &to->w}) fill(*component, brick, Real(0));
    }
  return bricks;
}

// Calls f(component, first, x, y, z, foot) for each face of a component in the bricks that are left in a row.
template <class VelocityAt, class F>
void for_each_foot_of_row(const Bricks& bricks, int row, const Faces<Real>& faces, Real cells,
                          const VelocityAt& velocity_at_face, Component component, const Vector3<float>& first,
                          const F& f) {
  bricks.for_each_span(faces.*component, row, [&](const Span& along_x, int y, int z) {
    for (int x = along_x.begin; x < along_x.end; ++x) {
      const Vector3<Real> face = {to_float(x) + first.x, to_float(y) + first.y, to_float(z) + first.z};
      const Vector3<Real> foot = foot_of<Index>(face, velocity_at_face(faces, x, y, z), faces, cells);
      f(component, first, x, y, z, foot);
    }
  });
}

template <class F>
void for_each_foot(const Bricks& bricks, const Faces<Real>& faces, Real dt, const F& f) {
  const Real cells = dt / faces.u.spacing;
  for (int row = 0; row < bricks.rows(); ++row) {
    for_each_foot_of_row(bricks, row, faces, cells, at_u, &Faces<Real>::u, first_u, f);
    for_each_foot_of_row(bricks, row, faces, cells, at_v, &Faces<Real>::v, first_v, f);
    for_each_foot_of_row(bricks, row, faces, cells, at_w, &Faces<Real>::w, first_w, f);
  }
}

}  // namespace

void advect_velocity_semi_lagrangian(const Faces<Real>& faces, Real dt, Faces<Real>& advected) {
  const Bricks bricks = bricks_to_trace(faces, {&advected});
  for_each_foot(bricks, faces, dt,
                [&](Component c, Vector3<float> first, int x, int y, int z, const Vector3<Real>& foot) {
                  (advected.*c)(x, y, z) = sample<Index>(faces.*c, first, foot);
                });
}

void advect_velocity_maccormack(const Faces<Real>& faces, Real dt, Faces<Real>& advected,
                                Arrived<Faces<Real>>& arrived) {
  const Bricks bricks = bricks_to_trace(faces, {&advected, &arrived.value});
  for_each_foot(bricks, faces, dt,
                [&](Component c, Vector3<float> first, int x, int y, int z, const Vector3<Real>& foot) {
                  const Bounded<Real> at = sample_bounded<Index>(faces.*c, first, foot);
                  (arrived.value.*c)(x, y, z) = at.value;
                  (arrived.least.*c)(x, y, z) = at.least;
                  (arrived.most.*c)(x, y, z) = at.most;
                });
  for_each_foot(
      bricks, faces, -dt, [&](Component c, Vector3<float> first, int x, int y, int z, const Vector3<Real>& back) {
        const Bounded<Real> at = {(arrived.value.*c)(x, y, z), (arrived.least.*c)(x, y, z), (arrived.most.*c)(x, y, z)};
        (advected.*c)(x, y, z) = corrected<Index>((faces.*c)(x, y, z), at, arrived.value.*c, first, back);
      });
}

}  // namespace lockstep::production_fluid::serial
