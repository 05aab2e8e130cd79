// The uniform grid that finds the neighbours of the game fluid's particles.
#pragma once

#include <array>
#include <cstdint>

#include "common/fluid/model.h"
#include "common/math.h"

namespace lockstep::fluid {

// One axis of the domain, cut into cells.
template <class Real>
struct Axis {
  Real min, max;  // m, where the walls stand
  int cells;
  Real cells_per_metre;  // 1/m
};

// Cells no narrower than h, so that a particle's neighbours stand in its own cell and the 26 around it. Cell (x, y, z)
// has the index (z * y.cells + y) * x.cells + x: the cells of a row along x follow one another, and once the particles
// are in cell order so do their particles. Points outside the domain belong to the nearest border cell, which keeps
// points within h of each other in adjacent cells.
template <class Real>
struct Grid {
  Axis<Real> x, y, z;
  // Particles of cell c, once rebuild_grid has run: cell_begin[c] .. cell_begin[c + 1]. Owned.
  Array<std::int32_t> cell_begin;

  int cells() const { return x.cells * y.cells * z.cells; }
  int cell(int cell_x, int cell_y, int cell_z) const { return (cell_z * y.cells + cell_y) * x.cells + cell_x; }
};

// Particles begin .. end - 1.
struct Run {
  int begin, end;
};

// The particles of cells (x_first .. x_last, y, z), clamped to the grid along x: one run, as they are in cell order.
template <class Real>
Run row_run(const Grid<Real>& grid, int x_first, int x_last, int y, int z) {
  const int first = x_first < 0 ? 0 : x_first, last = x_last < grid.x.cells ? x_last : grid.x.cells - 1;
  return {grid.cell_begin[grid.cell(first, y, z)], grid.cell_begin[grid.cell(last, y, z) + 1]};
}

// The particles of planes z_first .. z_last of cells, clamped to the grid.
template <class Real>
Run plane_run(const Grid<Real>& grid, int z_first, int z_last) {
  const int last = z_last < grid.z.cells ? z_last : grid.z.cells - 1;
  return {grid.cell_begin[grid.cell(0, 0, z_first)], grid.cell_begin[grid.cell(0, 0, last + 1)]};
}

// Up to nine runs, to be walked by a range-based for.
struct Runs {
  std::array<Run, 9> run;
  int count = 0;

  void add(Run r) { run[count++] = r; }
  const Run* begin() const { return run.data(); }
  const Run* end() const { return run.data() + count; }
};

// The particles that may lie within h of one in cell (x, y, z): three cells of each of the up to nine rows around it.
template <class Real>
Runs neighbour_runs(const Grid<Real>& grid, int x, int y, int z) {
  Runs runs;
  for (int row_z = z - 1; row_z <= z + 1; ++row_z)
    for (int row_y = y - 1; row_y <= y + 1; ++row_y)
      if (row_y >= 0 && row_y < grid.y.cells && row_z >= 0 && row_z < grid.z.cells)
        runs.add(row_run(grid, x - 1, x + 1, row_y, row_z));
  return runs;
}

// Half of them, so that every pair of particles is met once: the cells (x_first .. x_last, y, z) and what follows them
// in cell order. A particle i of these cells meets those of the first run that come after it, and all of the others.
template <class Real>
Runs forward_runs(const Grid<Real>& grid, int x_first, int x_last, int y, int z) {
  Runs runs;
  runs.add(row_run(grid, x_first, x_last + 1, y, z));
  if (y + 1 < grid.y.cells) runs.add(row_run(grid, x_first - 1, x_last + 1, y + 1, z));
  for (int row_y = y - 1; row_y <= y + 1; ++row_y)
    if (row_y >= 0 && row_y < grid.y.cells && z + 1 < grid.z.cells)
      runs.add(row_run(grid, x_first - 1, x_last + 1, row_y, z + 1));
  return runs;
}

// The same for one cell.
template <class Real>
Runs forward_runs(const Grid<Real>& grid, int x, int y, int z) {
  return forward_runs(grid, x, x, y, z);
}

// The coordinate of the cell along one axis that holds p, clamped to 0 .. axis.cells - 1; NaN counts as 0. T is Real or
// lanes.
template <class Real, class T>
auto cell_coordinate(const Axis<Real>& axis, T p) {
  return to_int(min(max((p - T(axis.min)) * T(axis.cells_per_metre), T(Real(0))), T(Real(axis.cells - 1))));
}

// The index of the cell that holds the point p. Number is Real, or lanes of points.
template <class Real, class Number>
auto cell_of(const Grid<Real>& grid, const Vector3<Number>& p) {
  using Index = decltype(cell_coordinate(grid.x, p.x));
  const Index x = cell_coordinate(grid.x, p.x), y = cell_coordinate(grid.y, p.y), z = cell_coordinate(grid.z, p.z);
  return (z * Index(grid.y.cells) + y) * Index(grid.x.cells) + x;
}

// The grid of a model's domain: as many cells as fit along each axis with cells at least h wide, one where h is wider
// than the domain. Cells are kept wider than h by more than the rounding of a cell coordinate, so that it cannot
// separate neighbours. Allocates cell_begin; rebuild_grid fills it.
template <class Real>
Grid<Real> make_grid(const Model<Real>& model) {
  const auto cut = [&](Real min, Real max) -> Axis<Real> {
    const double range = double(max) - double(min);
    const double fit = range / (model.smoothing_length * (1 + 1e-5));
    const int cells = fit < 1 ? 1 : static_cast<int>(fit);
    return {.min = min, .max = max, .cells = cells, .cells_per_metre = static_cast<Real>(cells / range)};
  };
  Grid<Real> grid{.x = cut(model.domain_min.x, model.domain_max.x),
                  .y = cut(model.domain_min.y, model.domain_max.y),
                  .z = cut(model.domain_min.z, model.domain_max.z),
                  .cell_begin = {}};
  grid.cell_begin.resize(grid.cells() + 1);
  return grid;
}

}  // namespace lockstep::fluid
