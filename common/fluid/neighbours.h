// Who lies within h of whom: found once a frame, by the densities, and used again by the forces.
#pragma once

#include <cstdint>
#include <vector>

#include "common/fluid/grid.h"

namespace lockstep::fluid {

// A list of neighbours for every particle, itself not among them. Lists are kept a row of cells at a time, so that threads
// may fill rows side by side: those of the row's first particle come first, and end[i] is where particle i's end. Owned.
template <class Real>
struct Neighbours {
  std::vector<Array<std::int32_t>> row;  // [row of cells z * grid.y.cells + y]: indices of particles, as they stand in the arrays
  Array<std::int32_t> end;               // [particle]: into its row's array; the next particle's list begins there
  Array<Real> record;                    // [8 particle + k]: scratch of the forces, where they want a particle's numbers side by side
};

template <class Real>
Neighbours<Real> make_neighbours(const Grid<Real>& grid, int particles) {
  Neighbours<Real> neighbours;
  neighbours.row.resize(grid.y.cells * grid.z.cells);
  neighbours.end.resize(padded(particles));
  neighbours.record.resize(8 * padded(particles));
  return neighbours;
}

}  // namespace lockstep::fluid
