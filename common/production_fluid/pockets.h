// Pockets of liquid that air cannot reach (make_system.h). Sequential: it works on runs of cells, of which a line has
// few.
#pragma once

#include <algorithm>
#include <numeric>
#include <span>
#include <vector>

#include "common/production_fluid/system.h"

namespace lockstep::production_fluid {

// A run's share of its pocket: whether one of its cells has air beside it, and the sum of `right` over its cells.
struct RunSum {
  bool open;
  double right;
};

// For each run, what to subtract from `right` in its cells: the mean over its pocket; 0 where air reaches the liquid.
// Empty if there are no pockets. Liquid cells that share a face are connected: so are runs of neighbouring lines that
// overlap along x.
template <class Real>
Array<Real> means_of_pockets(const System<Real>& system, std::span<const RunSum> sums) {
  const auto [nx, ny, nz] = system.cells;
  const int runs = static_cast<int>(system.runs.size());
  std::vector<std::int32_t> joined(runs);  // union-find: a run that this one is connected with, itself at a root
  std::iota(joined.begin(), joined.end(), 0);
  const auto root = [&](std::int32_t run) {
    while (joined[run] != run) run = joined[run] = joined[joined[run]];
    return run;
  };
  const auto join_lines = [&](int a, int b) {
    int i = system.first_run[a], j = system.first_run[b];
    while (i < system.first_run[a + 1] && j < system.first_run[b + 1]) {
      const Run &one = system.runs[i], &other = system.runs[j];
      if (one.begin < other.end && other.begin < one.end) {
        const std::int32_t first = root(i), second = root(j);
        joined[std::max(first, second)] = std::min(first, second);
      }
      one.end < other.end ? ++i : ++j;
    }
  };
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y) {
      if (y > 0) join_lines(y + ny * z, y - 1 + ny * z);
      if (z > 0) join_lines(y + ny * z, y + ny * (z - 1));
    }

  struct Pocket {
    bool open = false;
    double sum = 0, cells = 0;
  };
  std::vector<Pocket> pockets(runs);  // at the first run of each
  for (int run = 0; run < runs; ++run) {
    Pocket& pocket = pockets[root(run)];
    pocket.open |= sums[run].open;
    pocket.sum += sums[run].right;
    pocket.cells += system.runs[run].end - system.runs[run].begin;
  }
  Array<Real> means(runs);
  bool any = false;
  for (int run = 0; run < runs; ++run) {
    const Pocket& pocket = pockets[root(run)];
    means[run] = pocket.open ? Real(0) : static_cast<Real>(pocket.sum / pocket.cells);
    any |= !pocket.open;
  }
  return any ? means : Array<Real>();
}

// Whether a cell with a row has air beside it. Its diagonal counts 1 for each liquid neighbour, and at least 1 for each
// face to the air. `neighbours` are the diagonals of the six cells around it.
template <class Number>
inline auto has_air_beside(const Number& diagonal, const Number (&neighbours)[6]) {
  Number rest = diagonal;
  for (const Number& neighbour : neighbours) rest = rest - select(neighbour > Number(0), Number(1), Number(0));
  return rest > Number(.5f);
}

}  // namespace lockstep::production_fluid
