// Lists of neighbours, particles within h of each other: the densities make them once a frame, and the forces use them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "common/fluid/grid.h"
#include "common/input_error.h"
#include "common/memory.h"

namespace lockstep::fluid {

// A list of neighbours for every particle, without the particle itself. The lists of a row of cells stand one after
// another in one array, in the order of the particles, so that threads may fill rows side by side. An array holds
// padded(its entries) elements; what fills it up are indices of any particles. Owned.
template <class Real>
struct Neighbours {
  // [row of cells z * grid.y.cells + y]: indices of particles, as they stand in the arrays.
  std::vector<Array<std::int32_t>> row;
  Array<std::int32_t> end;  // [particle]: where its list ends in the row's array; the next particle's begins there
  Array<Real> scratch;      // [8 padded(particles)]: of openmp/ within a call, kept so that it is allocated once

  // Of the pair lists, where every pair stands once, in the list of the particle that comes first in cell order: the
  // lists of a plane of cells in one array, padded likewise, and end[i] is a place in the plane's array.
  std::vector<Array<std::int32_t>> plane;  // [z]: indices of particles
  std::vector<Array<Real>> distance_2;     // [z]: the squared distance of the pair, m^2
};

// Fills up an array of which all elements are entries.
template <class T>
void pad(Array<T>& list) {
  list.resize(padded(list.size()));
}

template <class Real>
Neighbours<Real> make_neighbours(const Grid<Real>& grid, int particles) {
  Neighbours<Real> neighbours;
  neighbours.row.resize(grid.y.cells * grid.z.cells);
  neighbours.plane.resize(grid.z.cells);
  neighbours.distance_2.resize(grid.z.cells);
  neighbours.end.resize(padded(particles));
  neighbours.scratch.resize(8 * padded(particles));
  return neighbours;
}

// How crowded the cells are, which bounds the entries of the lists: a list has as many as there are particles within h,
// so if all particles crowd into one cell, all of them.
struct Crowding {
  std::int32_t cell = 0;      // particles, at most, in a cell
  double plane = 0, all = 0;  // entries, at most, in the lists of a plane of cells, and of all planes
};

// Of cell c, particles.
template <class Real>
std::int32_t particles_in(const Grid<Real>& grid, int c) {
  return grid.cell_begin[c + 1] - grid.cell_begin[c];
}

// Whether the lists fit wherever the particles stand, if no cell holds more than `crowd`.
template <class Real>
bool lists_surely_fit(const Grid<Real>& grid, std::int32_t crowd) {
  constexpr double entry = sizeof(std::int32_t), surely_fits = 1e9;
  return 27. * crowd * grid.cell_begin.back() * entry < surely_fits;
}

// Of plane z of cells, entries at most in its lists.
template <class Real>
double most_entries(const Grid<Real>& grid, int z) {
  double entries = 0;
  for (int y = 0; y < grid.y.cells; ++y)
    for (int x = 0; x < grid.x.cells; ++x) {
      double candidates = 0;
      for (const Run& run : neighbour_runs(grid, x, y, z)) candidates += run.end - run.begin;
      entries += particles_in(grid, grid.cell(x, y, z)) * candidates;
    }
  return entries;
}

// Throws InputError where the lists of a plane might have more entries than int32 counts, or all lists might take more
// memory than there is.
inline void require_lists_fit(const Crowding& most) {
  constexpr double most_in_a_plane = 1 << 30;  // lists grow by doubling
  if (most.plane > most_in_a_plane)
    throw InputError("up to " + std::to_string(most.cell) +
                     " particles in a cell: too crowded for lists of neighbours");
  require_memory(most.all * sizeof(std::int32_t),
                 "up to " + std::to_string(most.cell) + " particles in a cell: lists of neighbours");
}

// The same of the particles in a grid, before a list is written. The symmetric forms keep no lists and can run such a
// state. In parallel: openmp/fluid/lists_fit.h.
template <class Real>
void require_lists_fit(const Grid<Real>& grid) {
  Crowding most;
  for (int c = 0; c < grid.cells(); ++c) most.cell = std::max(most.cell, particles_in(grid, c));
  if (lists_surely_fit(grid, most.cell)) return;
  for (int z = 0; z < grid.z.cells; ++z) {
    const double plane = most_entries(grid, z);
    most.plane = std::max(most.plane, plane);
    most.all += plane;
  }
  require_lists_fit(most);
}

}  // namespace lockstep::fluid
