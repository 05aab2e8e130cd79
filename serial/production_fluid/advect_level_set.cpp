// Moves the level set with the velocity.
//
// Each centre asks where its value comes from and interpolates phi there, so values stay between those that were there,
// however long the step. Interpolation smooths: corners of the surface become round, and thin sheets vanish. Particles
// give back part of what is lost. semi_lagrangian is of first order; maccormack, which `step` uses, carries smooth
// shapes with second order. Its first pass writes every cell, so the second finds what arrived wherever it looks.
//
// The contract stands in common/production_fluid/advect_level_set.h.
#include "common/production_fluid/advect_level_set.h"

#include <initializer_list>

#include "common/real.h"
#include "serial/production_fluid/bricks.h"

namespace lockstep::production_fluid::serial {
namespace {

using Index = std::int32_t;

Vector3<Real> at_centre(const Faces<Real>& faces, int x, int y, int z) {
  const auto& [u, v, w] = faces;
  return {mean(u(x, y, z), u(x + 1, y, z)), mean(v(x, y, z), v(x, y + 1, z)), mean(w(x, y, z), w(x, y, z + 1))};
}

// Whether nothing is faster than `most`. Planes are read from end to end, which the processor foresees better than the
// short lines of a row of bricks.
bool is_slow(const Faces<Real>& faces, Real most) {
  const auto is_below = [=](const Real& speed) { return abs(speed) <= most; };
  bool all_are = true;
  for (int z = 0; z < faces.w.nz; ++z)
    for (const Field<Real>* component : {&faces.u, &faces.v, &faces.w})
      all_are = all_are && all_in(*component, {{0, component->nx}, {0, component->ny}, {z, z + 1}}, is_below);
  return all_are;
}

// The bricks whose cells must be traced. In the others, all values that a foot can lie between are equal, and the cells
// of `advected` get that value. Speeds are asked for last: to read them all takes long.
Bricks bricks_to_trace(const Field<Real>& phi, const Faces<Real>& faces, Real dt,
                       std::initializer_list<Field<Real>*> advected) {
  Bricks bricks(phi.nx, phi.ny, phi.nz);
  const auto value_of = [&](const Box& brick) { return phi(brick.x.begin, brick.y.begin, brick.z.begin); };
  for (int row = 0; row < bricks.rows(); ++row)
    for (int k = 0; k < bricks.along_x(); ++k) {
      const Box brick = bricks.brick(row, k);
      const Real value = value_of(brick);
      if (value != 0 && all_in(phi, around(brick), [=](const Real& q) { return q == value; })) bricks.settle(row, k);
    }
  if (bricks.all_are_left()) return bricks;
  if (!is_slow(faces, speed_of_a_cell(phi, dt / phi.spacing))) return Bricks(phi.nx, phi.ny, phi.nz);
  for (int row = 0; row < bricks.rows(); ++row)
    for (int k = 0; k < bricks.along_x(); ++k) {
      if (bricks.is_left(row, k)) continue;
      const Box brick = bricks.brick(row, k);
      for (Field<Real>* field : advected) fill(*field, brick, value_of(brick));
    }
  return bricks;
}

// Calls f(x, y, z, foot) for each centre of the bricks that are left.
template <class F>
void for_each_foot(const Bricks& bricks, const Field<Real>& phi, const Faces<Real>& faces, Real dt, const F& f) {
  const Real cells = dt / phi.spacing;
  const Vector3<float> first = first_centre;
  for (int row = 0; row < bricks.rows(); ++row)
    bricks.for_each_span(phi, row, [&](const Span& along_x, int y, int z) {
      for (int x = along_x.begin; x < along_x.end; ++x) {
        const Vector3<Real> centre = {to_float(x) + first.x, to_float(y) + first.y, to_float(z) + first.z};
        f(x, y, z, foot_of<Index>(centre, at_centre(faces, x, y, z), faces, cells));
      }
    });
}

}  // namespace

void advect_level_set_semi_lagrangian(const Field<Real>& phi, const Faces<Real>& faces, Real dt,
                                      Field<Real>& advected) {
  const Bricks bricks = bricks_to_trace(phi, faces, dt, {&advected});
  for_each_foot(bricks, phi, faces, dt, [&](int x, int y, int z, const Vector3<Real>& foot) {
    advected(x, y, z) = sample<Index>(phi, first_centre, foot);
  });
}

void advect_level_set_maccormack(const Field<Real>& phi, const Faces<Real>& faces, Real dt, Field<Real>& advected,
                                 Arrived<Field<Real>>& arrived) {
  const Bricks bricks = bricks_to_trace(phi, faces, dt, {&advected, &arrived.value});
  for_each_foot(bricks, phi, faces, dt, [&](int x, int y, int z, const Vector3<Real>& foot) {
    const Bounded<Real> at = sample_bounded<Index>(phi, first_centre, foot);
    arrived.value(x, y, z) = at.value;
    arrived.least(x, y, z) = at.least;
    arrived.most(x, y, z) = at.most;
  });
  for_each_foot(bricks, phi, faces, -dt, [&](int x, int y, int z, const Vector3<Real>& back) {
    const Bounded<Real> at = {arrived.value(x, y, z), arrived.least(x, y, z), arrived.most(x, y, z)};
    advected(x, y, z) = corrected<Index>(phi(x, y, z), at, arrived.value, first_centre, back);
  });
}

}  // namespace lockstep::production_fluid::serial
