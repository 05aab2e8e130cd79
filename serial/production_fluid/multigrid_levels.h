// The grids of multigrid's cycle, each with the places of its band. Every loop goes through all places of a grid.
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "common/production_fluid/multigrid.h"

namespace lockstep::production_fluid::serial {

template <class Real>
struct LevelOf {
  Bordered cells;
  Array<Real> diagonal, inverse;     // 0 where there is no row
  std::vector<std::size_t> band[2];  // where its cells stand, by colour
  int passes;                        // over the band
  Array<Real> right, solution;       // of a coarse grid
  Array<Real> guess;
};

template <class Real>
Kinds finest_kinds(const System<Real>& system) {
  Kinds kinds = make_kinds(system.cells, system.open_top);
  const auto [nx, ny, nz] = system.cells;
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) {
        const std::size_t i = system.cells.index(x, y, z);
        kinds.value[kinds.index(x, y, z)] = kind_of(system.diagonal[i] > 0, system.air[i]);
      }
  return kinds;
}

inline Kinds coarser_kinds(const Kinds& fine) {
  Kinds kinds = make_kinds(coarser(fine.cells), fine.open_top);
  const auto [nx, ny, nz] = kinds.cells;
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x)
        kinds.value[kinds.index(x, y, z)] =
            kind_of_parent(&fine.value[fine.index(2 * x, 2 * y, 2 * z)], fine.line(), fine.plane());
  return kinds;
}

template <class Real>
Array<Real> coarse_rows(const Kinds& kinds, PressureMemory<Real>& memory) {
  Array<Real> diagonal = memory.take_zeros(kinds.cells.size());
  const auto [nx, ny, nz] = kinds.cells;
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x)
        diagonal[kinds.cells.index(x, y, z)] =
            static_cast<Real>(row_of(&kinds.value[kinds.index(x, y, z)], kinds.line(), kinds.plane()));
  return diagonal;
}

template <class Real>
void find_band(const Kinds& kinds, LevelOf<Real>& level) {
  const auto [nx, ny, nz] = kinds.cells;
  Array<std::uint8_t> beside(kinds.size());
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) {
        const std::size_t i = kinds.index(x, y, z);
        beside[i] = is_beside_boundary(&kinds.value[i], kinds.line(), kinds.plane());
      }
  const bool all = is_coarsest(kinds.cells);
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) {
        const std::size_t i = kinds.index(x, y, z);
        if (kinds.value[i] == Kinds::liquid && (all || is_in_band(&beside[i], kinds.line(), kinds.plane())))
          level.band[colour_of(x, y, z)].push_back(kinds.cells.index(x, y, z));
      }
}

template <class Real>
LevelOf<Real> make_level(const Kinds& kinds, Array<Real> diagonal, PressureMemory<Real>& memory) {
  LevelOf<Real> level;
  level.cells = kinds.cells;
  level.passes = is_coarsest(kinds.cells) ? coarsest_passes : band_passes;
  level.inverse = memory.take(diagonal.size());
  for (std::size_t i = 0; i < diagonal.size(); ++i) level.inverse[i] = diagonal[i] > 0 ? 1 / diagonal[i] : 0;
  find_band(kinds, level);
  for (Array<Real>* array : {&level.right, &level.solution, &level.guess}) *array = memory.take_zeros(diagonal.size());
  level.diagonal = std::move(diagonal);
  return level;
}

template <class Real>
std::vector<LevelOf<Real>> make_levels(const System<Real>& system, PressureMemory<Real>& memory) {
  Kinds kinds = finest_kinds(system);
  std::vector<LevelOf<Real>> levels;
  Array<Real> finest = memory.take(system.diagonal.size());
  std::ranges::copy(system.diagonal, finest.begin());
  levels.push_back(make_level(kinds, std::move(finest), memory));
  while (!is_coarsest(kinds.cells)) {
    kinds = coarser_kinds(kinds);
    levels.push_back(make_level(kinds, coarse_rows(kinds, memory), memory));
  }
  return levels;
}

template <class Real>
void give_back(std::vector<LevelOf<Real>>& levels, PressureMemory<Real>& memory) {
  for (LevelOf<Real>& level : levels)
    for (Array<Real>* array : {&level.diagonal, &level.inverse, &level.right, &level.solution, &level.guess})
      memory.give_back(*array);
}

}  // namespace lockstep::production_fluid::serial
