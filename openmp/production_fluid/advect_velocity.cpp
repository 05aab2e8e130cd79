// Moves the velocity with itself.
//
// The algorithm and its serial form stand in serial/production_fluid/advect_velocity.cpp. Sixteen faces along x at
// once; threads share the rows of bricks. Faces of one line stand side by side, so what stands at them is loaded; what
// stands at a foot is mostly loaded, too (corners.h).
//
// The contract stands in common/production_fluid/advect_velocity.h.
#include "common/production_fluid/advect_velocity.h"

#include <initializer_list>

#include "common/real.h"
#include "common/simd.h"
#include "openmp/production_fluid/bricks.h"
#include "openmp/production_fluid/corners.h"
#include "openmp/production_fluid/feet.h"

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

// The bricks whose faces must be traced. In the others and beside them all velocities are 0, and the faces of
// `advected` get 0.
Bricks bricks_to_trace(const Faces<Real>& faces, std::initializer_list<Faces<Real>*> advected) {
  Bricks bricks(faces.v.nx, faces.u.ny, faces.u.nz);
  const auto is_zero = [](const Real& speed) { return speed == 0; };
  const struct { CommonValues u, v, w; } values = {CommonValues(faces.u), CommonValues(faces.v), CommonValues(faces.w)};
  // A row writes its own faces, and the marks of its own bricks.
#pragma omp parallel for schedule(static)
  for (int row = 0; row < bricks.rows(); ++row)
    for (int k = 0; k < bricks.along_x(); ++k) {
      const Box brick = bricks.brick(row, k), near = around(brick);
      if (!all_in(values.u, near, is_zero) || !all_in(values.v, near, is_zero) || !all_in(values.w, near, is_zero))
        continue;
      bricks.settle(row, k);
      for (Faces<Real>* to : advected)
        for (Field<Real>* component : {&to->u, &to->v, &to->w}) fill(*component, brick, Real(0));
    }
  return bricks;
}

// Calls f(component, first, x, y, z, inside, foot) for sixteen faces of a component at a time; `inside` marks those in
// bricks that are left in a row. f reads or writes the component of `used`.
template <class VelocityAt, class F>
void for_each_foot_of_row(const Bricks& bricks, int row, const Faces<Real>& faces, Real cells,
                          std::initializer_list<const Faces<Real>*> used, const VelocityAt& velocity_at_face,
                          Component component, const Vector3<float>& first, const F& f) {
  bricks.for_each_span(faces.*component, row, [&](const Span& along_x, int y, int z) {
    const auto foot_at = [&, ahead = line_ahead(faces.*component, y)](int x) {
      for (const Faces<Real>* field : used) __builtin_prefetch(&(field->*component)(x, ahead, z));
      const Vector3<floatv> face = {to_float(x + lane_index()) + first.x, to_float(y) + first.y, to_float(z) + first.z};
      return foot_of<Index>(face, velocity_at_face(faces, x, y, z), faces, cells);
    };
    for_each_foot_of_line(along_x, foot_at, [&](int x, maskv inside, const Vector3<floatv>& foot) {
      f(component, first, x, y, z, inside, foot);
    });
  });
}

template <class F>
void for_each_foot(const Bricks& bricks, const Faces<Real>& faces, Real dt,
                   std::initializer_list<const Faces<Real>*> used, const F& f) {
  const Real cells = dt / faces.u.spacing;
  // A row writes its own faces, in fields that none reads. Rows differ in how many bricks are left, hence dynamic.
#pragma omp parallel for schedule(dynamic)
  for (int row = 0; row < bricks.rows(); ++row) {
    for_each_foot_of_row(bricks, row, faces, cells, used, at_u, &Faces<Real>::u, first_u, f);
    for_each_foot_of_row(bricks, row, faces, cells, used, at_v, &Faces<Real>::v, first_v, f);
    for_each_foot_of_row(bricks, row, faces, cells, used, at_w, &Faces<Real>::w, first_w, f);
  }
}

}  // namespace

void advect_velocity_semi_lagrangian(const Faces<Real>& faces, Real dt, Faces<Real>& advected) {
  const Bricks bricks = bricks_to_trace(faces, {&advected});
  for_each_foot(bricks, faces, dt, {&faces, &advected},
                [&](Component c, Vector3<float> first, int x, int y, int z, maskv inside, const Vector3<floatv>& foot) {
                  store(&(advected.*c)(x, y, z), sample<Index>(faces.*c, first, foot), inside);
                });
}

void advect_velocity_maccormack(const Faces<Real>& faces, Real dt, Faces<Real>& advected,
                                Arrived<Faces<Real>>& arrived) {
  const Bricks bricks = bricks_to_trace(faces, {&advected, &arrived.value});
  for_each_foot(bricks, faces, dt, {&faces, &arrived.value, &arrived.least, &arrived.most},
                [&](Component c, Vector3<float> first, int x, int y, int z, maskv inside, const Vector3<floatv>& foot) {
                  const Bounded<floatv> at = sample_bounded<Index>(faces.*c, first, foot);
                  store(&(arrived.value.*c)(x, y, z), at.value, inside);
                  store(&(arrived.least.*c)(x, y, z), at.least, inside);
                  store(&(arrived.most.*c)(x, y, z), at.most, inside);
                });
  for_each_foot(bricks, faces, -dt, {&faces, &arrived.value, &arrived.least, &arrived.most, &advected},
                [&](Component c, Vector3<float> first, int x, int y, int z, maskv inside, const Vector3<floatv>& back) {
                  const Bounded<floatv> at = {load(&(arrived.value.*c)(x, y, z)), load(&(arrived.least.*c)(x, y, z)),
                                              load(&(arrived.most.*c)(x, y, z))};
                  const floatv better = corrected<Index>(load(&(faces.*c)(x, y, z)), at, arrived.value.*c, first, back);
                  store(&(advected.*c)(x, y, z), better, inside);
                });
}

}  // namespace lockstep::production_fluid::openmp
