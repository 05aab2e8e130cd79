// What tests of advection share: fields and flows that are known, and all forms under one signature.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <limits>
#include <utility>

#include "common/production_fluid/advect_level_set.h"
#include "common/production_fluid/advect_velocity.h"

namespace lockstep::production_fluid {

using LevelSet = AdvectLevelSet<float>;
using Velocity = AdvectVelocity<float>;

constexpr float u = std::numeric_limits<float>::epsilon() / 2;
constexpr float poison = -12345;

inline Field<float> poisoned(Field<float> field) {
  std::fill(field.value.begin(), field.value.end(), poison);
  return field;
}
inline Faces<float> poisoned(const Faces<float>& faces) {
  return {poisoned(faces.u), poisoned(faces.v), poisoned(faces.w)};
}
// A kernel writes every point of a poisoned field, and no padding.
inline void expect_padding_is_poison(const Field<float>& field) {
  EXPECT_EQ(std::count(field.value.begin(), field.value.end(), poison),
            std::ptrdiff_t(field.value.size()) - std::ptrdiff_t(field.nx) * field.ny * field.nz);
}
inline void expect_padding_is_poison(const Faces<float>& faces) {
  expect_padding_is_poison(faces.u), expect_padding_is_poison(faces.v), expect_padding_is_poison(faces.w);
}

// Of scratch, a kernel may leave points as they were, but all padding.
inline void expect_only_points_change(Field<float> scratch) {
  for (int z = 0; z < scratch.nz; ++z)
    for (int y = 0; y < scratch.ny; ++y)
      for (int x = 0; x < scratch.nx; ++x) scratch(x, y, z) = 0;
  expect_padding_is_poison(scratch);
}
inline void expect_only_points_change(const Faces<float>& scratch) {
  expect_only_points_change(scratch.u), expect_only_points_change(scratch.v), expect_only_points_change(scratch.w);
}

// With scratch of any content.
template <AdvectLevelSetMacCormack<float>* advect>
void with_scratch(const Field<float>& phi, const Faces<float>& faces, float dt, Field<float>& advected) {
  Arrived<Field<float>> arrived{poisoned(phi), poisoned(phi), poisoned(phi)};
  advect(phi, faces, dt, advected, arrived);
  for (const Field<float>* field : {&arrived.value, &arrived.least, &arrived.most}) expect_only_points_change(*field);
}
template <AdvectVelocityMacCormack<float>* advect>
void with_scratch(const Faces<float>& faces, float dt, Faces<float>& advected) {
  Arrived<Faces<float>> arrived{poisoned(faces), poisoned(faces), poisoned(faces)};
  advect(faces, dt, advected, arrived);
  for (const Faces<float>* part : {&arrived.value, &arrived.least, &arrived.most}) expect_only_points_change(*part);
}

inline constexpr LevelSet* corrected_level_sets[] = {with_scratch<serial::advect_level_set_maccormack>,
                                                     with_scratch<openmp::advect_level_set_maccormack>};
inline constexpr Velocity* corrected_velocities[] = {with_scratch<serial::advect_velocity_maccormack>,
                                                     with_scratch<openmp::advect_velocity_maccormack>};
inline constexpr LevelSet* level_sets[] = {serial::advect_level_set_semi_lagrangian,
                                           openmp::advect_level_set_semi_lagrangian, corrected_level_sets[0],
                                           corrected_level_sets[1]};
inline constexpr Velocity* velocities[] = {serial::advect_velocity_semi_lagrangian,
                                           openmp::advect_velocity_semi_lagrangian, corrected_velocities[0],
                                           corrected_velocities[1]};

// value(x, y, z) of a point in cells from the corner of the box.
template <class Real, class F>
void fill(Field<Real>& field, const Vector3<float>& first, F value) {
  for (int z = 0; z < field.nz; ++z)
    for (int y = 0; y < field.ny; ++y)
      for (int x = 0; x < field.nx; ++x)
        field(x, y, z) = static_cast<Real>(value(x + double(first.x), y + double(first.y), z + double(first.z)));
}

template <class Real, class F>
Field<Real> level_set(int nx, int ny, int nz, Real spacing, const F& value) {
  Field<Real> phi = levelset::make_field<Real>(nx, ny, nz, spacing, 0);
  fill(phi, first_centre, value);
  return phi;
}

template <class Real, class U, class V, class W>
Faces<Real> faces_of(int nx, int ny, int nz, Real spacing, const U& of_u, const V& of_v, const W& of_w) {
  Faces<Real> faces = make_faces<Real>(nx, ny, nz, spacing);
  fill(faces.u, first_u, of_u), fill(faces.v, first_v, of_v), fill(faces.w, first_w, of_w);
  return faces;
}
template <class Real = float>
Faces<Real> constant(int nx, int ny, int nz, Real spacing, const Vector3<double>& velocity) {
  const auto is = [](double component) { return [component](double, double, double) { return component; }; };
  return faces_of(nx, ny, nz, spacing, is(velocity.x), is(velocity.y), is(velocity.z));
}

inline Field<float> advected(LevelSet* advect, const Field<float>& phi, const Faces<float>& faces, float dt) {
  Field<float> result = poisoned(phi);
  advect(phi, faces, dt, result);
  return result;
}
inline Faces<float> advected(Velocity* advect, const Faces<float>& faces, float dt) {
  Faces<float> result = poisoned(faces);
  advect(faces, dt, result);
  return result;
}

// Numbers from -1 to 1.
struct Numbers {
  unsigned state = 1;
  template <class... Any>
  double operator()(Any...) {
    return static_cast<double>((state = state * 1664525u + 1013904223u) >> 8) * 0x1p-23 - 1;
  }
};
template <class Real = float>
Faces<Real> random_faces(int nx, int ny, int nz, Real spacing, double largest) {
  Numbers number;
  const auto any = [&](double, double, double) { return largest * number(); };
  return faces_of(nx, ny, nz, spacing, any, any, any);
}

// Calls f(x, y, z, value) for each point.
template <class Real, class F>
void for_each_point(const Field<Real>& field, const F& f) {
  for (int z = 0; z < field.nz; ++z)
    for (int y = 0; y < field.ny; ++y)
      for (int x = 0; x < field.nx; ++x) f(x, y, z, field(x, y, z));
}
template <class F>
void for_each_component(const Faces<float>& a, const Faces<float>& b, const F& f) {
  f(a.u, b.u), f(a.v, b.v), f(a.w, b.w);
}

inline std::pair<float, float> range_of(const Field<float>& field) {
  float least = std::numeric_limits<float>::max(), most = -least;
  for_each_point(field, [&](int, int, int, float v) { least = std::min(least, v), most = std::max(most, v); });
  return {least, most};
}

}  // namespace lockstep::production_fluid
