// Solves the system of the pressure by conjugate gradients with a V-cycle of multigrid.
//
// The algorithm and its serial form stand in serial/production_fluid/multigrid.cpp. Every operation takes sixteen
// places that stand side by side, and threads share the places. Jacobi's iteration, residuals and transfers read one
// array and write another. In the band, cells of a colour read the other colour alone: lanes of other cells are masked
// out, and loads do not touch what they would read.
//
// The contract stands in common/production_fluid/multigrid.h.
#include "common/production_fluid/multigrid.h"

#include <omp.h>

#include <vector>

#include "common/linear/iterate.h"
#include "common/real.h"
#include "common/simd.h"
#include "common/simd_double.h"
#include "openmp/production_fluid/guess.h"
#include "openmp/production_fluid/multigrid_levels.h"
#include "openmp/production_fluid/prefetch.h"

namespace lockstep::production_fluid::openmp {
namespace {

static_assert(linear::dot_lanes == lanes);

// Calls f(i) for each vector of a part, in order; i is where it stands.
template <class F>
LOCKSTEP_INLINE void for_each_vector(const Part& part, const F& f) {
  for (std::ptrdiff_t i = part.begin; i < part.end; i += lanes) f(i);
}

// Calls f(i) for each vector that has rows.
template <class F>
void for_each_place(const Level& level, const F& f) {
  const std::ptrdiff_t count = std::ssize(level.parts);
  // What f writes belongs to its vector.
#pragma omp parallel for schedule(static) if (is_shared(level))
  for (std::ptrdiff_t k = 0; k < count; ++k) for_each_vector(level.parts[k], f);
}

// The sum of f(i), sixteen numbers a vector, as dot products are summed. Vectors without rows would add 0 to sums that
// began at 0, which changes no bit.
template <class F>
double sum(const Level& level, const F& f) {
  const std::ptrdiff_t count = std::ssize(level.parts);
  std::vector<double> sums(count);
  // A part writes its own sum, and what f writes belongs to its vector.
#pragma omp parallel for schedule(static) if (is_shared(level))
  for (std::ptrdiff_t k = 0; k < count; ++k) {
    doublev of_lanes = 0.;
    for_each_vector(level.parts[k], [&](std::size_t i) { of_lanes = of_lanes + f(i); });
    sums[k] = reduce_add(of_lanes);
  }
  double sum = 0;
  for (const double s : sums) sum += s;
  return sum;
}

// What the loop of conjugate gradients does with vectors (common/linear/dot.h, update.h).
struct Vectors {
  const Level& level;

  double dot(std::span<const Real> x, std::span<const Real> y) const {
    return sum(level, [&](std::size_t i) { return to_double(load(&x[i])) * to_double(load(&y[i])); });
  }
  void axpy(Real a, std::span<const Real> x, std::span<Real> y) const {
    for_each_place(level, [&](std::size_t i) { store(&y[i], load(&y[i]) + a * load(&x[i])); });
  }
  void advance(Real a, std::span<const Real> z, Real b, std::span<Real> x, std::span<Real> p) const {
    for_each_place(level, [&](std::size_t i) {
      const floatv along = load(&p[i]);
      store(&x[i], load(&x[i]) + a * along);
      store(&p[i], load(&z[i]) + b * along);
    });
  }
  double descend(Real a, std::span<const Real> q, std::span<Real> r) const {
    return sum(level, [&](std::size_t i) {
      const floatv rest = load(&r[i]) - a * load(&q[i]);
      store(&r[i], rest);
      return to_double(rest) * to_double(rest);
    });
  }
};

// --- The cycle

// Rows of A x.
LOCKSTEP_INLINE floatv row_times(const Level& level, const Real* x, std::size_t i) {
  const std::ptrdiff_t line = level.cells.line(), plane = level.cells.plane();
  const Real* const at = x + i;
  prefetch<ahead>(at + plane, &(*level.diagonal)[i]);
  return product(load(&(*level.diagonal)[i]), load(at), load(at - 1), load(at + 1), load(at - line), load(at + line),
                 load(at - plane), load(at + plane));
}

// What solves rows for their own z. load_beside loads neighbours.
template <class LoadBeside>
LOCKSTEP_INLINE floatv solve_row(const Level& level, std::span<const Real> right, const Array<Real>& z, std::size_t i,
                                 const LoadBeside& load_beside) {
  const std::ptrdiff_t line = level.cells.line(), plane = level.cells.plane();
  const Real* const at = &z[i];
  return gauss_seidel(load(&level.inverse[i]), load(&right[i]), load_beside(at - 1), load_beside(at + 1),
                      load_beside(at - line), load_beside(at + line), load_beside(at - plane), load_beside(at + plane));
}

void first_guess(Level& level, std::span<const Real> right) {
  for_each_place(level, [&](std::size_t i) {
    store(&level.guess[i], jacobi(floatv(0.f), load(&level.inverse[i]) * load(&right[i])));
  });
}

void smooth_band(Level& level, std::span<const Real> right, int first_colour) {
  const std::ptrdiff_t count = std::ssize(level.band);
#pragma omp parallel if (is_shared(level))
  for (int half = 0; half < 2 * level.passes; ++half) {
    // Cells of a colour read only the other colour, which the barrier at this loop's end has completed.
#pragma omp for schedule(static)
    for (std::ptrdiff_t k = 0; k < count; ++k) {
      const Patch& patch = level.band[k];
      const maskv active = lanes_of(patch.of_colour[(first_colour + half) % 2]);
      const std::size_t i = static_cast<std::size_t>(patch.vector) * lanes;
      const auto load_active = [&](const Real* p) { return load(p, active); };
      store(&level.guess[i], solve_row(level, right, level.guess, i, load_active), active);
    }
  }
}

// Returns right . z: conjugate gradients need it, and here both are at hand.
double smooth(const Level& level, std::span<const Real> right, std::span<Real> z) {
  const auto load_all = [](const Real* p) { return load(p); };
  return sum(level, [&](std::size_t i) {
    prefetch<ahead>(&level.guess[i + level.cells.plane()], &level.inverse[i], &right[i]);
    const floatv found = jacobi(load(&level.guess[i]), solve_row(level, right, level.guess, i, load_all));
    store(&z[i], found);
    return to_double(load(&right[i])) * to_double(found);
  });
}

void find_residual(const Level& level, std::span<const Real> right, std::span<Real> residual) {
  for_each_place(level, [&](std::size_t i) {
    const floatv rest = load(&right[i]) - row_times(level, level.guess.data(), i);
    store(&residual[i], select(load(&(*level.diagonal)[i]) > 0.f, rest, 0.f));
  });
}

// Calls f(line, of_line) for each line of a grid that has rows. of_line holds numbers of a line of at most `n` cells,
// with room for lanes and for cells beyond both ends.
template <class F>
void for_each_line(const Level& level, int n, const F& f) {
  const std::ptrdiff_t count = std::ssize(level.lines);
  const std::size_t room = padded(n) + 4 * lanes;  // a thread
  Array<Real> rooms(room * omp_get_max_threads());
#pragma omp parallel if (is_shared(level))
  {
    Real* const of_line = &rooms[room * omp_get_thread_num() + lanes];
    // What f writes belongs to its line, and of_line to its thread.
#pragma omp for schedule(static)
    for (std::ptrdiff_t k = 0; k < count; ++k) f(level.lines[k], of_line);
  }
}

// The coarser grid's right-hand side: along z, then along y, then along x.
void restrict_residual(const Level& fine, std::span<const Real> residual, Level& coarse) {
  const int nx = fine.cells.nx, ny = fine.cells.ny, nz = fine.cells.nz;
  const Real scale = restriction_scale(fine.cells);
  for_each_line(coarse, nx, [&](const Span& line, Real* of_line) {
    const Real* from[4][4];
    for (int j = 0; j < 4; ++j)
      for (int k = 0; k < 4; ++k)
        from[j][k] =
            &residual[fine.cells.index(0, fine_place(2 * line.y - 1 + j, ny), fine_place(2 * line.z - 1 + k, nz))];
    for (int x = std::max(0, 2 * line.begin - 1); x < std::min(nx, 2 * line.end + 1); x += lanes) {
      floatv along_z[4];
      for (int j = 0; j < 4; ++j)
        along_z[j] = restricted(load(from[j][0] + x), load(from[j][1] + x), load(from[j][2] + x), load(from[j][3] + x));
      store(&of_line[x], restricted(along_z[0], along_z[1], along_z[2], along_z[3]));
    }
    of_line[-1] = of_line[0];
    of_line[nx] = nx % 2 == 0 ? of_line[nx - 1] : 0;
    of_line[nx + 1] = 0;
    const std::size_t i = coarse.cells.index(0, line.y, line.z);
    const Real* const diagonal = &(*coarse.diagonal)[i];
    Real* const right = &coarse.right[i];
    // An iteration writes its own element of `right`.
#pragma omp simd
    for (int x = line.begin; x < line.end; ++x) {
      const Real* const at = of_line + 2 * x;
      right[x] = select(diagonal[x] > 0, scale * restricted(at[-1], at[0], at[1], at[2]), 0.f);
    }
  });
}

// Adds the coarser grid's correction: along z, then along y, then along x.
void add_correction(const Level& coarse, Level& fine) {
  const int nx = coarse.cells.nx, ny = coarse.cells.ny, nz = coarse.cells.nz;
  for_each_line(fine, nx, [&](const Span& line, Real* of_line) {
    const int y[2] = {line.y / 2, next_place(line.y, ny)}, z[2] = {line.z / 2, next_place(line.z, nz)};
    const Real* from[2][2];
    for (int j = 0; j < 2; ++j)
      for (int k = 0; k < 2; ++k) from[j][k] = &coarse.solution[coarse.cells.index(0, y[j], z[k])];
    for (int x = std::max(0, line.begin / 2 - 1); x < std::min(nx, line.end / 2 + 1); x += lanes) {
      floatv along_z[2];
      for (int j = 0; j < 2; ++j) along_z[j] = interpolated(load(from[j][0] + x), load(from[j][1] + x));
      store(&of_line[x], interpolated(along_z[0], along_z[1]));
    }
    of_line[-1] = of_line[0];
    of_line[nx] = of_line[nx - 1];
    const std::size_t i = fine.cells.index(0, line.y, line.z);
    for (int x = line.begin / 2; 2 * x < line.end; x += lanes) {
      const floatv parent = load(of_line + x);
      Real added[2 * lanes];
      store_pairs(added, interpolation_scale * interpolated(parent, load(of_line + x - 1)),
                  interpolation_scale * interpolated(parent, load(of_line + x + 1)));
      for (int half = 0; half < 2; ++half) {
        const int first = 2 * x + half * lanes;
        const maskv in_line = first_lanes(line.end - first);
        Real* const to = &fine.guess[i + first];
        const maskv row = rows_from(fine, i + first) & in_line;
        store(to, load(to, row) + load(added + half * lanes), row);
      }
    }
  });
}

// z = M^-1 r on a level; returns r . z. Until the end, z holds the residual.
double cycle(std::vector<Level>& levels, std::size_t of, std::span<const Real> r, std::span<Real> z) {
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
  return smooth(level, r, z);
}

// --- What conjugate gradients need besides

double multiply(const Level& finest, std::span<const Real> x, std::span<Real> y) {
  return sum(finest, [&](std::size_t i) {
    const floatv row = row_times(finest, x.data(), i);
    const floatv found = select(load(&(*finest.diagonal)[i]) > 0.f, row, 0.f);
    store(&y[i], found);
    return to_double(load(&x[i])) * to_double(found);
  });
}

// Adds x to the pressure, sets x to 0, and computes the residual of the pressure.
double refresh(const System<Real>& system, const Level& finest, Array<double>& q, std::span<Real> x,
               std::span<Real> r) {
  for_each_place(finest, [&](std::size_t i) {
    store(&q[i], load(&q[i]) + to_double(load(&x[i])));
    store(&x[i], floatv(0.f));
  });
  const std::ptrdiff_t line = system.cells.line(), plane = system.cells.plane();
  return sum(finest, [&](std::size_t i) {
    const double* const at = &q[i];
    const floatv diagonal = load(&system.diagonal[i]);
    const doublev row = product(to_double(diagonal), load(at), load(at - 1), load(at + 1), load(at - line),
                                load(at + line), load(at - plane), load(at + plane));
    const floatv rest = select(diagonal > 0.f, to_float(to_double(load(&system.right[i])) - row), 0.f);
    store(&r[i], rest);
    return to_double(rest) * to_double(rest);
  });
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
      .multiply = [&](std::span<const Real> x, std::span<Real> y) { return multiply(levels[0], x, y); },
      .precondition = [&](std::span<const Real> x, std::span<Real> y) { return cycle(levels, 0, x, y); },
      .residual = nullptr,
      .refresh = [&](std::span<Real> x, std::span<Real> r) { return refresh(system, levels[0], q, x, r); },
      .start = start};
  const auto zeros = [&] { return take_zeros(memory, system.cells.size()); };
  Array<Real> x = zeros(), r = zeros(), z = zeros(), p = zeros();
  const linear::Solution solution =
      linear::iterate(Vectors{levels[0]}, operators, system.right, {x, r, z, p}, settings.stop);
  for (Array<Real>* array : {&x, &r, &z, &p}) give_back_zeros(levels[0], *array, memory);
  give_back(levels, memory);
  return solution;
}

}  // namespace lockstep::production_fluid::openmp
