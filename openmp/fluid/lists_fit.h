// Whether the lists of neighbours fit (require_lists_fit, common/fluid/neighbours.h), by all threads: the work goes
// with the number of cells, and one thread would keep the others waiting.
#pragma once

#include <algorithm>
#include <vector>

#include "common/fluid/neighbours.h"

namespace lockstep::fluid::openmp {

// Throws as its serial twin does.
template <class Real>
void require_lists_fit_in_parallel(const Grid<Real>& grid) {
  std::int32_t cell = 0;
  // Iterations only read; each thread has its own greatest until the region ends.
#pragma omp parallel for schedule(static) reduction(max : cell)
  for (int c = 0; c < grid.cells(); ++c) cell = std::max(cell, particles_in(grid, c));
  if (lists_surely_fit(grid, cell)) return;

  std::vector<double> planes(grid.z.cells);
  // Plane z writes planes[z] alone.
#pragma omp parallel for schedule(static)
  for (int z = 0; z < grid.z.cells; ++z) planes[z] = most_entries(grid, z);
  Crowding most{.cell = cell};
  for (const double plane : planes) most.plane = std::max(most.plane, plane), most.all += plane;
  require_lists_fit(most);
}

}  // namespace lockstep::fluid::openmp
