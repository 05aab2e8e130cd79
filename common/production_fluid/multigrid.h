// Contract: a V-cycle of multigrid, the preconditioner of pressure_solve_multigrid (pressure_solve.h).
//
// Levels. A cell of the next coarser grid has eight children; where the box is odd, some of them are beyond it. It is
// air if any child is air, else liquid if any is liquid, else solid. Its row counts its liquid neighbours and its air
// neighbours: the finest level alone knows where within a cell the surface is (theta, make_system.h). Grids go on until
// no axis has more than `coarsest_cells`.
//
// Smoothers. Jacobi's iteration with damping goes over all cells. It is weak beside boundaries, because the coarser
// grid has them elsewhere. So the cells within two of a boundary, the band, get Gauss-Seidel passes as well, in two
// colours: cells where x + y + z is even, and the others. A boundary is a face to air, or to a solid cell in the box.
// The walls of the box are none: every grid has them in the same place, and transfers mirror there. On the coarsest
// grid all cells are the band, and passes are as many as solve it well.
//
//   cycle, A z = r:   z = damping r / diagonal
//                     passes over the band, even cells first
//                     e = cycle of the coarser grid for R (r - A z);  z += P e     (not on the coarsest)
//                     passes over the band, odd cells first
//                     Jacobi: z += damping ((r + sum of z over neighbours) / diagonal - z)
//
// Transfers. P interpolates: a child takes 3/4 of its parent's value and 1/4 of the next cell's on its side, axis after
// axis. Beyond a wall, the next cell is the parent itself. R is P's transpose but for a factor, so that along an axis
// it takes a mean, with weights (1 3 3 1) / 8; times 4, because coarse cells are twice as long and rows have the unit
// 1 / length^2. An axis of one cell stays as it is.
//
// The second half of a cycle mirrors the first. So z is linear in r, and the map is symmetric, and positive definite on
// the cells that have rows (notes/production_fluid.md).
//
// In:     system, with `air` and `open_top`; r, bordered as the system is, 0 in cells without a row.
// Out:    z in cells that have a row; bordered, and elsewhere 0 before and after.
// Source: McAdams, Sifakis and Teran, A parallel multigrid Poisson solver for fluids simulation on large grids, SCA
//         2010, where walls are boundaries, too. Damping: Trottenberg, Oosterlee and Schueller, Multigrid (2001): 6/7
//         smooths best in three dimensions.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "common/array.h"
#include "common/production_fluid/pressure_solve.h"
#include "common/production_fluid/system.h"

namespace lockstep::production_fluid {

template <class Real>
using MultigridCycle = void(const System<Real>& system, std::span<const Real> r, std::span<Real> z);

namespace serial {
MultigridCycle<float> multigrid_cycle;
MultigridCycle<double> multigrid_cycle;
}  // namespace serial

namespace openmp {
MultigridCycle<float> multigrid_cycle;
}  // namespace openmp

inline constexpr int coarsest_cells = 4;   // along an axis
inline constexpr int band_passes = 2;      // before the coarser grid, and as many after it
inline constexpr int coarsest_passes = 8;  // likewise
inline constexpr float jacobi_damping = 6.f / 7;

// --- What is in a cell

// The kinds of a grid's cells, with a layer of cells around them: beyond the box are walls, and air above an open top.
// A coarse cell has the greatest kind of its children. An array of the same size may hold something else of each cell.
struct Kinds {
  enum : std::uint8_t { wall, solid, liquid, air };

  Bordered cells;
  bool open_top = false;
  Array<std::uint8_t> value;

  std::ptrdiff_t line() const { return cells.nx + 2; }
  std::ptrdiff_t plane() const { return line() * (cells.ny + 2); }
  std::size_t index(int x, int y, int z) const {
    return static_cast<std::size_t>((z + 1) * plane() + (y + 1) * line() + x + 1);
  }
  std::size_t size() const { return padded(static_cast<std::size_t>(plane() * (cells.nz + 2))); }
};

// All walls, but for the air above an open top.
inline Kinds make_kinds(const Bordered& cells, bool open_top) {
  Kinds kinds = {cells, open_top, {}};
  kinds.value.assign(kinds.size(), Kinds::wall);
  for (int z = 0; z < cells.nz && open_top; ++z)
    std::fill_n(&kinds.value[kinds.index(0, cells.ny, z)], cells.nx, std::uint8_t(Kinds::air));
  return kinds;
}

inline Bordered coarser(const Bordered& cells) { return {(cells.nx + 1) / 2, (cells.ny + 1) / 2, (cells.nz + 1) / 2}; }
inline bool is_coarsest(const Bordered& cells) { return std::max({cells.nx, cells.ny, cells.nz}) <= coarsest_cells; }

// Of a cell on the finest grid. Liquid without an open face has no row, and counts as solid.
inline std::uint8_t kind_of(bool has_row, std::uint8_t is_air) {
  return has_row ? Kinds::liquid : is_air ? Kinds::air : Kinds::solid;
}

inline std::uint8_t greater(std::uint8_t a, std::uint8_t b) { return a > b ? a : b; }

// The greatest kind of the children whose first is *at.
inline std::uint8_t kind_of_parent(const std::uint8_t* at, std::ptrdiff_t line, std::ptrdiff_t plane) {
  const auto of_line = [](const std::uint8_t* at) { return greater(at[0], at[1]); };
  const auto of_plane = [&](const std::uint8_t* at) { return greater(of_line(at), of_line(at + line)); };
  return greater(of_plane(at), of_plane(at + plane));
}

// The diagonal of a coarse cell's row, 0 if it has none.
inline int row_of(const std::uint8_t* at, std::ptrdiff_t line, std::ptrdiff_t plane) {
  const auto open = [&](std::ptrdiff_t to) { return int(at[to] >= Kinds::liquid); };
  return at[0] == Kinds::liquid ? open(-1) + open(1) + open(-line) + open(line) + open(-plane) + open(plane) : 0;
}

// Whether a cell has a boundary beside it.
inline std::uint8_t is_beside_boundary(const std::uint8_t* at, std::ptrdiff_t line, std::ptrdiff_t plane) {
  const auto bounds = [&](std::ptrdiff_t to) { return (at[to] == Kinds::solid) | (at[to] == Kinds::air); };
  return (at[0] == Kinds::liquid) &
         (bounds(-1) | bounds(1) | bounds(-line) | bounds(line) | bounds(-plane) | bounds(plane));
}

// Whether a liquid cell is in the band, given which cells are beside a boundary.
inline std::uint8_t is_in_band(const std::uint8_t* beside, std::ptrdiff_t line, std::ptrdiff_t plane) {
  return beside[0] | beside[-1] | beside[1] | beside[-line] | beside[line] | beside[-plane] | beside[plane];
}

inline int colour_of(int x, int y, int z) { return (x + y + z) % 2; }

// --- Formulas; of numbers or of lanes

// What solves a row for its own unknown.
template <class Number>
inline Number gauss_seidel(const Number& inverse, const Number& right, const Number& low_x, const Number& high_x,
                           const Number& low_y, const Number& high_y, const Number& low_z, const Number& high_z) {
  return inverse * (right + (((low_x + high_x) + (low_y + high_y)) + (low_z + high_z)));
}

// From z to what solves the row, `found`, with damping.
template <class Number>
inline Number jacobi(const Number& z, const Number& found) {
  return z + Number(jacobi_damping) * (found - z);
}

// R along an axis, but for the scale: of fine cells 2 X - 1 to 2 X + 2.
template <class Number>
inline Number restricted(const Number& a, const Number& b, const Number& c, const Number& d) {
  return (a + d) + Number(3) * (b + c);
}
inline float restriction_scale(const Bordered& fine) {
  const auto of_axis = [](int n) { return n == 1 ? 1.f / 4 : 1.f / 8; };
  return 4 * of_axis(fine.nx) * of_axis(fine.ny) * of_axis(fine.nz);
}

// P along an axis, but for the scale.
template <class Number>
inline Number interpolated(const Number& parent, const Number& next) {
  return Number(3) * parent + next;
}
inline constexpr float interpolation_scale = 1.f / (4 * 4 * 4);

// The fine cell, of n along an axis, that R reads for x = -1 .. n + 1. At a wall the outermost cell is mirrored. Where
// n is odd, the last coarse cell has one child only; for x = n and n + 1, place n is read, where arrays hold 0.
inline int fine_place(int x, int n) { return x < 0 ? 0 : x < n ? x : n % 2 == 0 ? n - 1 : n; }

// The next coarse cell, of n along an axis, on the side of fine cell x.
inline int next_place(int x, int n) { return std::clamp(x / 2 + (x % 2 == 0 ? -1 : 1), 0, n - 1); }

}  // namespace lockstep::production_fluid
