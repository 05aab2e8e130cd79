// Solves the system of the pressure by conjugate gradients with a V-cycle of multigrid.
//
// A smoother such as Jacobi's removes errors that change from cell to cell in a few sweeps, and hardly touches errors
// that change slowly. On a grid of twice the spacing, those change quickly. So a cycle smooths, hands the residual to
// the coarser grid, which does the same, and smooths again. The number of iterations then hardly depends on the number
// of cells, where with an incomplete factor it grows as the cells along an axis do.
//
// A free surface does not fit into coarse cells. Beside it, the correction of the coarser grid is wrong, and as a
// preconditioner the cycle would be little better than the factor. Passes over a thin band of cells there mend that.
//
// All loops but those over the band go straight through arrays. Where a cell has no row, they find 0.
//
// The contract stands in common/production_fluid/multigrid.h.
#include "common/production_fluid/multigrid.h"

#include <vector>

#include "common/linear/iterate.h"
#include "common/real.h"
#include "serial/production_fluid/guess.h"
#include "serial/production_fluid/multigrid_levels.h"

namespace lockstep::production_fluid::serial {
namespace {

using Level = LevelOf<Real>;

// --- The cycle

// Calls f(i) for all places from the first cell to the last, those of the border among them.
template <class F>
void for_each_place(const Bordered& cells, const F& f) {
  const std::size_t end = cells.index(0, 0, cells.nz);
  for (std::size_t i = cells.index(0, 0, 0); i < end; ++i) f(i);
}

// Row i of A x.
template <class T>
T row_times(const Bordered& cells, const Array<Real>& diagonal, const T* x, std::size_t i) {
  const std::ptrdiff_t line = cells.line(), plane = cells.plane();
  const T* const at = x + i;
  return product<T>(diagonal[i], at[0], at[-1], at[1], at[-line], at[line], at[-plane], at[plane]);
}

// What solves row i for z(i).
Real solve_row(const Level& level, std::span<const Real> right, const Array<Real>& z, std::size_t i) {
  const std::ptrdiff_t line = level.cells.line(), plane = level.cells.plane();
  const Real* const at = &z[i];
  return gauss_seidel(level.inverse[i], right[i], at[-1], at[1], at[-line], at[line], at[-plane], at[plane]);
}

void first_guess(Level& level, std::span<const Real> right) {
  for_each_place(level.cells, [&](std::size_t i) { level.guess[i] = jacobi(Real(0), level.inverse[i] * right[i]); });
}

void smooth_band(Level& level, std::span<const Real> right, int first_colour) {
  for (int half = 0; half < 2 * level.passes; ++half)
    for (const std::size_t i : level.band[(first_colour + half) % 2])
      level.guess[i] = solve_row(level, right, level.guess, i);
}

void smooth(const Level& level, std::span<const Real> right, std::span<Real> z) {
  for_each_place(level.cells,
                 [&](std::size_t i) { z[i] = jacobi(level.guess[i], solve_row(level, right, level.guess, i)); });
}

void find_residual(const Level& level, std::span<const Real> right, std::span<Real> residual) {
  for_each_place(level.cells, [&](std::size_t i) {
    const Real rest = right[i] - row_times(level.cells, level.diagonal, level.guess.data(), i);
    residual[i] = level.diagonal[i] > 0 ? rest : 0;
  });
}

// The coarser grid's right-hand side: along z, then along y, then along x.
void restrict_residual(const Level& fine, std::span<const Real> residual, Level& coarse) {
  const int nx = fine.cells.nx, ny = fine.cells.ny, nz = fine.cells.nz;
  const Real scale = restriction_scale(fine.cells);
  for (int z = 0; z < coarse.cells.nz; ++z)
    for (int y = 0; y < coarse.cells.ny; ++y)
      for (int x = 0; x < coarse.cells.nx; ++x) {
        const std::size_t i = coarse.cells.index(x, y, z);
        if (!(coarse.diagonal[i] > 0)) continue;
        const auto of_four = [](int first, int n, const auto& f) {
          return restricted(f(fine_place(first, n)), f(fine_place(first + 1, n)), f(fine_place(first + 2, n)),
                            f(fine_place(first + 3, n)));
        };
        coarse.right[i] =
            scale * of_four(2 * x - 1, nx, [&](int fx) {
              return of_four(2 * y - 1, ny, [&](int fy) {
                return of_four(2 * z - 1, nz, [&](int fz) { return residual[fine.cells.index(fx, fy, fz)]; });
              });
            });
      }
}

// Adds the coarser grid's correction: along z, then along y, then along x.
void add_correction(const Level& coarse, Level& fine) {
  const int nx = coarse.cells.nx, ny = coarse.cells.ny, nz = coarse.cells.nz;
  for (int z = 0; z < fine.cells.nz; ++z)
    for (int y = 0; y < fine.cells.ny; ++y)
      for (int x = 0; x < fine.cells.nx; ++x) {
        const std::size_t i = fine.cells.index(x, y, z);
        if (!(fine.diagonal[i] > 0)) continue;
        const auto of_two = [](int fine, int n, const auto& f) {
          return interpolated(f(fine / 2), f(next_place(fine, n)));
        };
        fine.guess[i] +=
            Real(interpolation_scale) * of_two(x, nx, [&](int cx) {
              return of_two(y, ny, [&](int cy) {
                return of_two(z, nz, [&](int cz) { return coarse.solution[coarse.cells.index(cx, cy, cz)]; });
              });
            });
      }
}

// z = M^-1 r on a level. Until the end, z holds the residual.
void cycle(std::vector<Level>& levels, std::size_t of, std::span<const Real> r, std::span<Real> z) {
  Level& level = levels[of];
  first_guess(level, r);
  smooth_band(level, r, 0);
  if (of + 1 < levels.size()) {
    Level& coarse = levels[of + 1];
    find_residual(level, r, z);
    restrict_residual(level, z, coarse);
    cycle(levels, of + 1, coarse.right, coarse.solution);
    add_correction(coarse, level);
  }
  smooth_band(level, r, 1);
  smooth(level, r, z);
}

// --- What conjugate gradients need besides

double multiply(const System<Real>& system, std::span<const Real> x, std::span<Real> y) {
  for_each_place(system.cells, [&](std::size_t i) {
    const Real row = row_times(system.cells, system.diagonal, x.data(), i);
    y[i] = system.diagonal[i] > 0 ? row : 0;
  });
  return linear::serial::dot(x, y);
}

// Adds x to the pressure, sets x to 0, and computes the residual of the pressure.
double refresh(const System<Real>& system, Array<double>& q, std::span<Real> x, std::span<Real> r) {
  for_each_place(system.cells, [&](std::size_t i) { q[i] += x[i], x[i] = 0; });
  for_each_place(system.cells, [&](std::size_t i) {
    const double row = row_times(system.cells, system.diagonal, q.data(), i);
    r[i] = system.diagonal[i] > 0 ? static_cast<Real>(system.right[i] - row) : 0;
  });
  return linear::serial::dot(r, r);
}

}  // namespace

void multigrid_cycle(const System<Real>& system, std::span<const Real> r, std::span<Real> z) {
  PressureMemory<Real> memory;
  std::vector<Level> levels = make_levels(system, memory);
  cycle(levels, 0, r, z);
}

linear::Solution pressure_solve_multigrid(const System<Real>& system, const PressureSettings& settings,
                                          PressureMemory<Real>& memory, Array<double>& q) {
  const auto start = start_of(system, settings.guess, memory, q);
  std::vector<Level> levels = make_levels(system, memory);
  const linear::System<Real> operators = {
      .multiply = [&](std::span<const Real> x, std::span<Real> y) { return multiply(system, x, y); },
      .precondition =
          [&](std::span<const Real> x, std::span<Real> y) {
            cycle(levels, 0, x, y);
            return linear::serial::dot(x, y);
          },
      .residual = nullptr,
      .refresh = [&](std::span<Real> x, std::span<Real> r) { return refresh(system, q, x, r); },
      .start = start};
  const linear::VectorKernels<Real> vectors = {linear::serial::dot, linear::serial::axpy, linear::serial::advance,
                                               linear::serial::descend};
  const auto zeros = [&] { return memory.take_zeros(system.cells.size()); };
  Array<Real> x = zeros(), r = zeros(), z = zeros(), p = zeros();
  const linear::Solution solution = linear::iterate(vectors, operators, system.right, {x, r, z, p}, settings.stop);
  for (Array<Real>* array : {&x, &r, &z, &p}) memory.give_back(*array);
  give_back(levels, memory);
  return solution;
}

}  // namespace lockstep::production_fluid::serial
