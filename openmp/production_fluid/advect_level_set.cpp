// Moves the level set with the velocity.
//
// The algorithm and its serial form stand in serial/production_fluid/advect_level_set.cpp. Sixteen cells along x at
// once; threads share the rows of bricks. What stands at a foot is mostly loaded, not gathered (corners.h).
//
// The contract stands in common/production_fluid/advect_level_set.h.
#include "common/production_fluid/advect_level_set.h"

#include <initializer_list>

#include "common/real.h"
#include "common/simd.h"
#include "openmp/production_fluid/bricks.h"
#include "openmp/production_fluid/corners.h"
#include "openmp/production_fluid/feet.h"

namespace lockstep::production_fluid::openmp {
namespace {

using Index = intv;

Vector3<floatv> at_centre(const Faces<Real>& faces, int x, int y, int z) {
  const auto& [u, v, w] = faces;
  return {mean(load(&u(x, y, z)), load(&u(x + 1, y, z))), mean(load(&v(x, y, z)), load(&v(x, y + 1, z))),
          mean(load(&w(x, y, z)), load(&w(x, y, z + 1)))};
}

// Whether nothing is faster than `most`. Planes are read from end to end, which the processor foresees better than the
// short lines of a row of bricks.
bool is_slow(const Faces<Real>& faces, Real most) {
  const auto is_below = [=](const floatv& speed) { return abs(speed) <= most; };
  bool all_are = true;
  // Planes are only read. Each thread has its own answer, and a logical and of these is the same in any order.
#pragma omp parallel for schedule(static) reduction(&& : all_are)
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
  // A row writes the marks of its own bricks.
#pragma omp parallel for schedule(static)
  for (int row = 0; row < bricks.rows(); ++row)
    for (int k = 0; k < bricks.along_x(); ++k) {
      const Box brick = bricks.brick(row, k);
      const Real value = value_of(brick);
      if (value != 0 && all_in(phi, around(brick), [=](const floatv& q) { return q == value; })) bricks.settle(row, k);
    }
  if (bricks.all_are_left()) return bricks;
  if (!is_slow(faces, speed_of_a_cell(phi, dt / phi.spacing))) return Bricks(phi.nx, phi.ny, phi.nz);

    // A row writes its own cells.
#pragma omp parallel for schedule(static)
  for (int row = 0; row < bricks.rows(); ++row)
    for (int k = 0; k < bricks.along_x(); ++k) {
      if (bricks.is_left(row, k)) continue;
      const Box brick = bricks.brick(row, k);
      for (Field<Real>* field : advected) fill(*field, brick, value_of(brick));
    }
  return bricks;
}

// Calls f(x, y, z, inside, foot) for sixteen centres at a time; `inside` marks those in bricks that are left. f reads
// or writes the fields of `used`, of phi's shape.
template <class F>
void for_each_foot(const Bricks& bricks, const Field<Real>& phi, const Faces<Real>& faces, Real dt,
                   std::initializer_list<const Field<Real>*> used, const F& f) {
  const Real cells = dt / phi.spacing;
  const Vector3<float> first = first_centre;
  // A row writes its own cells, in fields that none reads. Rows differ in how many bricks are left, hence dynamic.
#pragma omp parallel for schedule(dynamic)
  for (int row = 0; row < bricks.rows(); ++row)
    bricks.for_each_span(phi, row, [&](const Span& along_x, int y, int z) {
      const auto foot_at = [&, ahead = line_ahead(phi, y)](int x) {
        for (const Field<Real>* field : {&faces.u, &faces.v, &faces.w}) __builtin_prefetch(&(*field)(x, ahead, z));
        for (const Field<Real>* field : used) __builtin_prefetch(&(*field)(x, ahead, z));
        const Vector3<floatv> centre = {to_float(x + lane_index()) + first.x, to_float(y) + first.y,
                                        to_float(z) + first.z};
        return foot_of<Index>(centre, at_centre(faces, x, y, z), faces, cells);
      };
      for_each_foot_of_line(along_x, foot_at,
                            [&](int x, maskv inside, const Vector3<floatv>& foot) { f(x, y, z, inside, foot); });
    });
}

}  // namespace

void advect_level_set_semi_lagrangian(const Field<Real>& phi, const Faces<Real>& faces, Real dt,
                                      Field<Real>& advected) {
  const Bricks bricks = bricks_to_trace(phi, faces, dt, {&advected});
  for_each_foot(bricks, phi, faces, dt, {&phi, &advected},
                [&](int x, int y, int z, maskv inside, const Vector3<floatv>& foot) {
                  store(&advected(x, y, z), sample<Index>(phi, first_centre, foot), inside);
                });
}

void advect_level_set_maccormack(const Field<Real>& phi, const Faces<Real>& faces, Real dt, Field<Real>& advected,
                                 Arrived<Field<Real>>& arrived) {
  const Bricks bricks = bricks_to_trace(phi, faces, dt, {&advected, &arrived.value});
  for_each_foot(bricks, phi, faces, dt, {&phi, &arrived.value, &arrived.least, &arrived.most},
                [&](int x, int y, int z, maskv inside, const Vector3<floatv>& foot) {
                  const Bounded<floatv> at = sample_bounded<Index>(phi, first_centre, foot);
                  store(&arrived.value(x, y, z), at.value, inside);
                  store(&arrived.least(x, y, z), at.least, inside);
                  store(&arrived.most(x, y, z), at.most, inside);
                });
  for_each_foot(bricks, phi, faces, -dt, {&phi, &arrived.value, &arrived.least, &arrived.most, &advected},
                [&](int x, int y, int z, maskv inside, const Vector3<floatv>& back) {
                  const Bounded<floatv> at = {load(&arrived.value(x, y, z)), load(&arrived.least(x, y, z)),
                                              load(&arrived.most(x, y, z))};
                  const floatv better = corrected<Index>(load(&phi(x, y, z)), at, arrived.value, first_centre, back);
                  store(&advected(x, y, z), better, inside);
                });
}

}  // namespace lockstep::production_fluid::openmp
