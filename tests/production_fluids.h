// What tests of the production fluid share: small fluids.
#pragma once

#include <cstdint>
#include <cstring>
#include <random>
#include <vector>

#include "common/linear/matrix.h"
#include "common/production_fluid/pressure_memory.h"
#include "common/production_fluid/state.h"
#include "common/production_fluid/system.h"

namespace lockstep::production_fluid {

// Scratch in which solves of other systems have left what they pleased.
template <class Real>
PressureMemory<Real>& scratch_for(const System<Real>&) {
  static PressureMemory<Real> scratch;
  return scratch;
}

// All elements of a field, in its order.
template <class Real, class F>
void for_each_place(const Field<Real>& field, const F& f) {
  for (int z = 0; z < field.nz; ++z)
    for (int y = 0; y < field.ny; ++y)
      for (int x = 0; x < field.nx; ++x) f(x, y, z);
}

// Without obstacles and at rest, in a closed box; phi(x, y, z) of the centre of a cell, m.
template <class Real, class Phi>
Fluid<Real> make_fluid(int nx, int ny, int nz, double spacing, const Phi& phi) {
  const Real h = static_cast<Real>(spacing);
  Fluid<Real> fluid = {.nx = nx,
                       .ny = ny,
                       .nz = nz,
                       .spacing = h,
                       .open_top = false,
                       .phi = levelset::make_field<Real>(nx, ny, nz, h, 0),
                       .solid = levelset::make_field<Real>(nx, ny, nz, h, -1),
                       .velocity = make_faces<Real>(nx, ny, nz, h)};
  for_each_place(fluid.phi, [&](int x, int y, int z) {
    fluid.phi(x, y, z) = static_cast<Real>(phi((x + .5) * spacing, (y + .5) * spacing, (z + .5) * spacing));
    fluid.solid(x, y, z) = 1;
  });
  return fluid;
}

// Unlike ==, it tells zeros apart.
inline bool same_bits(const Array<float>& a, const Array<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}
inline bool same_bits(const Faces<float>& a, const Faces<float>& b) {
  return same_bits(a.u.value, b.u.value) && same_bits(a.v.value, b.v.value) && same_bits(a.w.value, b.w.value);
}

enum class Kind { liquid, air, closed };

// What is in a cell, or beyond the box.
template <class Real>
Kind cell_at(const Fluid<Real>& fluid, int x, int y, int z) {
  if (y == fluid.ny && fluid.open_top) return Kind::air;
  if (x < 0 || x >= fluid.nx || y < 0 || y >= fluid.ny || z < 0 || z >= fluid.nz) return Kind::closed;
  if (fluid.solid(x, y, z) < 0) return Kind::closed;
  return fluid.phi(x, y, z) < 0 ? Kind::liquid : Kind::air;
}

// Calls f(component, axis, x, y, z, before, behind) for each face: what is in the cells beside it.
template <class Real, class F>
void for_each_face(const Fluid<Real>& fluid, const Faces<Real>& faces, const F& f) {
  const Field<Real>* const components[] = {&faces.u, &faces.v, &faces.w};
  for (int axis = 0; axis < 3; ++axis)
    for_each_place(*components[axis], [&](int x, int y, int z) {
      f(*components[axis], axis, x, y, z, cell_at(fluid, x - (axis == 0), y - (axis == 1), z - (axis == 2)),
        cell_at(fluid, x, y, z));
    });
}

// Calls f(value) for all elements of a field.
template <class Real, class F>
void for_each_cell(Field<Real>& field, const F& f) {
  for_each_place(field, [&](int x, int y, int z) { f(field(x, y, z)); });
}

// Cells of side 1/8 m, full of air, at rest, without obstacles.
inline Fluid<float> make_air(int nx, int ny, int nz) {
  return make_fluid<float>(nx, ny, nz, .125, [](double, double, double) { return 1.; });
}

// The same, all solid.
inline Fluid<float> make_box(int nx, int ny, int nz) {
  Fluid<float> fluid = make_air(nx, ny, nz);
  for_each_cell(fluid.solid, [](float& solid) { solid = -1; });
  return fluid;
}

// Liquid, air and solid cells at random, and random velocities.
inline Fluid<float> make_random(int nx, int ny, int nz, int seed) {
  std::mt19937 random(seed);
  const auto number = [&] { return static_cast<float>(static_cast<int>(random() % 2001) - 1000) / 1000; };
  Fluid<float> fluid = make_box(nx, ny, nz);
  for_each_cell(fluid.phi, [&](float& phi) { phi = number() - .3f; });
  for_each_cell(fluid.solid, [&](float& solid) { solid = number() + .8f; });
  for (Field<float>* faces : {&fluid.velocity.u, &fluid.velocity.v, &fluid.velocity.w})
    for_each_cell(*faces, [&](float& velocity) { velocity = number(); });
  fluid.open_top = random() % 2 == 0;
  return fluid;
}

// The matrix, its rows in the order of the cells, and where each row's cell stands.
struct Matrix {
  linear::Rows<float> rows;
  std::vector<std::size_t> place;
};
inline Matrix matrix_of(const System<float>& system) {
  Matrix matrix;
  for_each_run(system, [&](std::size_t first, int count, int) {
    for (int k = 0; k < count; ++k) matrix.place.push_back(first + k);
  });
  std::vector<int> row(system.cells.size(), -1);
  for (std::size_t i = 0; i < matrix.place.size(); ++i) row[matrix.place[i]] = static_cast<int>(i);
  const std::ptrdiff_t line = system.cells.line(), plane = system.cells.plane();
  matrix.rows.rows = matrix.rows.columns = static_cast<int>(matrix.place.size());
  for (const std::size_t at : matrix.place) {
    for (const std::ptrdiff_t to :
         {-plane, -line, std::ptrdiff_t(-1), std::ptrdiff_t(0), std::ptrdiff_t(1), line, plane})
      if (row[at + to] >= 0) {
        matrix.rows.column.push_back(row[at + to]);
        matrix.rows.value.push_back(to == 0 ? system.diagonal[at] : -1);
      }
    matrix.rows.begin.push_back(static_cast<int>(matrix.rows.column.size()));
  }
  return matrix;
}

}  // namespace lockstep::production_fluid
