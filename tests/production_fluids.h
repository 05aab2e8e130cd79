// What tests of the production fluid share: small fluids.
#pragma once

#include <cstdint>
#include <random>

#include "common/linear/matrix.h"
#include "common/production_fluid/state.h"
#include "common/production_fluid/system.h"

namespace lockstep::production_fluid {

// A box of cells of side 1/8 m, full of air, at rest.
inline Fluid<float> make_box(int nx, int ny, int nz) {
  return {.nx = nx,
          .ny = ny,
          .nz = nz,
          .spacing = .125f,
          .phi = levelset::make_field<float>(nx, ny, nz, .125f, 1),
          .solid = levelset::make_field<float>(nx, ny, nz, .125f, -1),
          .velocity = make_faces<float>(nx, ny, nz, .125f)};
}

template <class Real, class F>
void for_each_cell(Field<Real>& field, const F& f) {
  for (int z = 0; z < field.nz; ++z)
    for (int y = 0; y < field.ny; ++y)
      for (int x = 0; x < field.nx; ++x) f(field(x, y, z));
}

// No obstacles.
inline Fluid<float> make_air(int nx, int ny, int nz) {
  Fluid<float> fluid = make_box(nx, ny, nz);
  for_each_cell(fluid.solid, [](float& solid) { solid = 1; });
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
