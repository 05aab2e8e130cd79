// The linear system of the pressure, A q = b, with a row for each liquid cell.
#pragma once

#include <cstddef>
#include <cstdint>

#include "common/array.h"
#include "common/arrays.h"

namespace lockstep::production_fluid {

// Where cells stand in arrays that hold 0 wherever no cell is: one element after each line along x, one line before
// each plane, one plane before the first and one after the last. So neighbours beyond the box are there, and are 0.
// There is room for lanes before the first place and behind the last.
struct Bordered {
  int nx = 0, ny = 0, nz = 0;

  static constexpr std::ptrdiff_t front = 16;
  std::ptrdiff_t line() const { return nx + 1; }
  std::ptrdiff_t plane() const { return line() * (ny + 1); }
  std::size_t index(int x, int y, int z) const {
    return static_cast<std::size_t>(front + (z + 1) * plane() + (y + 1) * line() + x);
  }
  std::size_t size() const { return padded(static_cast<std::size_t>(front + plane() * (nz + 2) + line())); }
};

// Cells x = begin .. end - 1 of a line.
struct Run {
  std::int32_t begin, end;
};

// q = p dt / (rho h), m/s, where p is the pressure, dt the time step, rho the density and h the side of a cell. Row of
// cell c:
//
//   diagonal(c) q(c) - sum of q(n) over liquid neighbours n = right(c)
//
// Arrays are bordered; diagonal is > 0 in the cells that have a row, and 0 elsewhere, as right is. `air` is 1 in cells
// of air, which have no row, and 0 elsewhere.
template <class Real>
struct System {
  Bordered cells;
  Array<Real> diagonal, right;
  Array<std::int32_t> first_run{0};  // [y + ny z]: a line's first run; and the number of runs, behind the last
  Array<Run> runs;                   // the cells that have a row, line by line, in ascending order
  Array<std::uint8_t> air;
  bool open_top = false;  // air stands above the box
};

// Calls f(first, count, run) for each run of a line, or of all lines in order. `first` is where its first cell stands,
// `count` is its number of cells.
template <class Real, class F>
void for_each_run_of_line(const System<Real>& system, int y, int z, const F& f) {
  const int line = y + system.cells.ny * z;
  for (int run = system.first_run[line]; run < system.first_run[line + 1]; ++run) {
    const auto [begin, end] = system.runs[run];
    f(system.cells.index(begin, y, z), end - begin, run);
  }
}
template <class Real, class F>
void for_each_run(const System<Real>& system, const F& f) {
  for (int z = 0; z < system.cells.nz; ++z)
    for (int y = 0; y < system.cells.ny; ++y) for_each_run_of_line(system, y, z, f);
}

template <Same<Run> R, class F>
void for_each_field(R& run, const F& f) {
  f("begin", run.begin), f("end", run.end);
}

template <Is<System> S, class F>
void for_each_array(S& system, const F& f) {
  f("diagonal", system.diagonal, system.diagonal.size());
  f("right", system.right, system.right.size());
  f("first_run", system.first_run, system.first_run.size());
  f("runs", system.runs, system.runs.size());
  f("air", system.air, system.air.size());
}

}  // namespace lockstep::production_fluid
