// The papers' partition of the grid: one sub-grid a thread, and which cells need a lock. No serial twin: serial code
// has no one to share cells with.
//
// A thread updates the cells of its own sub-grid and, as pairs reach one cell further, the cells just outside it. So a
// cell whose 26 neighbours all lie in its own sub-grid is private to that sub-grid's thread and needs no lock; the
// others are shared and are updated under a lock. The larger the sub-grids, the smaller the share of cells at their
// borders.
//
// Source: [LRB08] "Thread Synchronization and software locks", Figure 9.
#pragma once

#include <algorithm>
#include <vector>

#include "common/fluid/grid.h"
#include "openmp/share.h"

namespace lockstep::fluid::openmp {

// Cells begin .. end - 1 along each axis.
struct SubGrid {
  lockstep::openmp::Share x, y, z;
};

struct SubGrids {
  std::vector<SubGrid> sub_grid;
  std::vector<char> shared;  // of each cell: whether two sub-grids' threads may update it
};

// Cuts [0, n) into parts of equal weight, weight[k] being that of the k-th element: parts + 1 ascending cuts.
inline std::vector<int> equal_cuts(const std::vector<long long>& weight, int parts) {
  const int n = static_cast<int>(weight.size());
  long long total = 0, sum = 0;
  for (long long w : weight) total += w;
  std::vector<int> cuts = {0};
  for (int k = 0; k < n; ++k) {
    sum += weight[k];
    while (static_cast<int>(cuts.size()) < parts && sum * parts >= total * static_cast<long long>(cuts.size()))
      cuts.push_back(k + 1);
  }
  cuts.resize(parts, n);
  cuts.push_back(n);
  return cuts;
}

// One sub-grid for each of `parts` threads, any number: the ways to write parts = a * b * c are all tried, each axis is
// cut into slices of equally many particles, and the cut that leaves the fewest particles in shared cells is taken.
template <class Real>
SubGrids make_sub_grids(const Grid<Real>& grid, int parts) {
  const int nx = grid.x.cells, ny = grid.y.cells, nz = grid.z.cells;
  const auto particles_in = [&](int cell) { return grid.cell_begin[cell + 1] - grid.cell_begin[cell]; };
  std::vector<long long> in_x(nx), in_y(ny), in_z(nz);
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) {
        const int n = particles_in(grid.cell(x, y, z));
        in_x[x] += n, in_y[y] += n, in_z[z] += n;
      }

  // A slice next to a cut is shared: what such slices hold is what would be updated under locks.
  const auto at_cuts = [](const std::vector<int>& cuts, const std::vector<long long>& weight) {
    long long sum = 0;
    for (std::size_t k = 1; k + 1 < cuts.size(); ++k)
      for (int slice : {cuts[k] - 1, cuts[k]})
        if (slice >= 0 && slice < static_cast<int>(weight.size())) sum += weight[slice];
    return sum;
  };
  std::vector<int> cut_x, cut_y, cut_z;
  long long fewest = -1;
  for (int a = 1; a <= parts; ++a)
    for (int b = 1; a * b <= parts; ++b) {
      if (parts % (a * b) != 0) continue;
      const std::vector<int> try_x = equal_cuts(in_x, a), try_y = equal_cuts(in_y, b),
                             try_z = equal_cuts(in_z, parts / (a * b));
      const long long at_border = at_cuts(try_x, in_x) + at_cuts(try_y, in_y) + at_cuts(try_z, in_z);
      if (fewest < 0 || at_border < fewest) fewest = at_border, cut_x = try_x, cut_y = try_y, cut_z = try_z;
    }

  SubGrids result{.sub_grid = {}, .shared = std::vector<char>(grid.cells(), 0)};
  for (std::size_t c = 0; c + 1 < cut_z.size(); ++c)
    for (std::size_t b = 0; b + 1 < cut_y.size(); ++b)
      for (std::size_t a = 0; a + 1 < cut_x.size(); ++a)
        result.sub_grid.push_back({{cut_x[a], cut_x[a + 1]}, {cut_y[b], cut_y[b + 1]}, {cut_z[c], cut_z[c + 1]}});
  const auto near_cut = [](const std::vector<int>& cuts, int k) {
    return std::any_of(cuts.begin() + 1, cuts.end() - 1, [&](int cut) { return k == cut - 1 || k == cut; });
  };
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x)
        result.shared[grid.cell(x, y, z)] = near_cut(cut_x, x) || near_cut(cut_y, y) || near_cut(cut_z, z);
  return result;
}

// The naive scheme: the same sub-grids, but every cell is locked for every update.
template <class Real>
SubGrids make_cell_locks(const Grid<Real>& grid, int parts) {
  SubGrids result = make_sub_grids(grid, parts);
  std::fill(result.shared.begin(), result.shared.end(), 1);
  return result;
}

// Part of a row of cells whose particles may be updated together: under lock `lock`, or freely where that is `no_lock`.
struct Piece {
  static constexpr int no_lock = -1;
  Run run;
  int lock;
};

// The row's cells x_first .. x_last, clamped to the grid: one piece where all are private, a piece a cell otherwise.
template <class Real, class Add>
void row_pieces(const Grid<Real>& grid, const SubGrids& sub_grids, int x_first, int x_last, int y, int z,
                const Add& add) {
  x_first = std::max(x_first, 0), x_last = std::min(x_last, grid.x.cells - 1);
  const char* shared = &sub_grids.shared[grid.cell(0, y, z)];
  if (std::none_of(shared + x_first, shared + x_last + 1, [](char s) { return s; })) {
    add(Piece{row_run(grid, x_first, x_last, y, z), Piece::no_lock});
  } else {
    for (int x = x_first; x <= x_last; ++x)
      add(Piece{row_run(grid, x, x, y, z), shared[x] ? grid.cell(x, y, z) : Piece::no_lock});
  }
}

// forward_runs (common/fluid/grid.h), in pieces.
template <class Real, class Add>
void forward_pieces(const Grid<Real>& grid, const SubGrids& sub_grids, int x, int y, int z, const Add& add) {
  row_pieces(grid, sub_grids, x, x + 1, y, z, add);
  if (y + 1 < grid.y.cells) row_pieces(grid, sub_grids, x - 1, x + 1, y + 1, z, add);
  for (int row_y = y - 1; row_y <= y + 1; ++row_y)
    if (row_y >= 0 && row_y < grid.y.cells && z + 1 < grid.z.cells)
      row_pieces(grid, sub_grids, x - 1, x + 1, row_y, z + 1, add);
}

}  // namespace lockstep::fluid::openmp
