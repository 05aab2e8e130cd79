// Solves the system of the pressure by conjugate gradients.
//
// Without a preconditioner, an iteration moves information by one cell. A solve with an incomplete Cholesky factor
// moves it through the whole grid, there and back, so that far fewer iterations are needed. The factor comes from
// elimination in the order of the cells. What would fill zeros of the matrix is added to the diagonal instead
// (modified), so that sums of rows are kept. tau and sigma keep the factor from breaking down.
//
// The matrix is never stored: off its diagonal it is -1 for each liquid neighbour. Where no liquid is, all vectors are
// 0, and contribute nothing.
//
// The contract stands in common/production_fluid/pressure_solve.h.
#include "common/production_fluid/pressure_solve.h"

#include <algorithm>

#include "common/linear/iterate.h"
#include "common/real.h"
#include "serial/production_fluid/guess.h"

namespace lockstep::production_fluid::serial {
namespace {

// Calls f(i) for each cell with a row; i is where it stands.
template <class F>
void for_each_cell(const System<Real>& system, const F& f) {
  for_each_run(system, [&](std::size_t first, int count, int) {
    for (int k = 0; k < count; ++k) f(first + k);
  });
}

// The sum over all planes of f(z), in the order of the contract.
template <class F>
double sum_of_planes(const System<Real>& system, const F& f) {
  double sum = 0;
  for (int first = 0; first < system.cells.nz; first += planes_of_a_sum) {
    double plane[planes_of_a_sum] = {};
    for (int l = 0; l < std::min(planes_of_a_sum, system.cells.nz - first); ++l) plane[l] = f(first + l);
    for (int half = planes_of_a_sum / 2; half > 0; half /= 2)
      for (int l = 0; l < half; ++l) plane[l] += plane[l + half];
    sum += plane[0];
  }
  return sum;
}

// Calls f(i) for each cell of a plane that has a row, in their order or in the opposite one.
template <class F>
void ascending(const System<Real>& system, int z, const F& f) {
  for (int y = 0; y < system.cells.ny; ++y)
    for_each_run_of_line(system, y, z, [&](std::size_t first, int count, int) {
      for (int k = 0; k < count; ++k) f(first + k);
    });
}
template <class F>
void descending(const System<Real>& system, int z, const F& f) {
  for (int y = system.cells.ny - 1; y >= 0; --y) {
    const int line = y + system.cells.ny * z;
    for (int run = system.first_run[line + 1] - 1; run >= system.first_run[line]; --run)
      for (int x = system.runs[run].end - 1; x >= system.runs[run].begin; --x) f(system.cells.index(x, y, z));
  }
}

// Row i of A x.
template <class T>
T row_times(const System<Real>& system, const T* x, std::size_t i) {
  const std::ptrdiff_t line = system.cells.line(), plane = system.cells.plane();
  const T* const at = x + i;
  return product<T>(system.diagonal[i], at[0], at[-1], at[1], at[-line], at[line], at[-plane], at[plane]);
}

// --- The factor

// How far from a cell its neighbours along z stand. Those of another block do not count in the factor: a plane of the
// border takes their place, which is 0.
struct Neighbours {
  std::ptrdiff_t low_z, high_z;
};
Neighbours neighbours_of(const Bordered& cells, int block, int z) {
  const std::ptrdiff_t plane = cells.plane(), none = -(z + 1) * plane;
  return {z % block > 0 ? -plane : none, (z + 1) % block > 0 ? plane : none};
}

// 1 / e of all cells.
Array<Real> make_inverses(const System<Real>& system, int block, const linear::Modification& modification,
                          PressureMemory<Real>& memory) {
  const Real tau = static_cast<Real>(modification.tau), sigma = static_cast<Real>(modification.sigma);
  const std::ptrdiff_t line = system.cells.line();
  Array<Real> inverse = memory.take_zeros(system.cells.size()), share = memory.take_zeros(system.cells.size());
  for (int z = 0; z < system.cells.nz; ++z) {
    const Neighbours n = neighbours_of(system.cells, block, z);
    ascending(system, z, [&](std::size_t i) {
      const Real* const diagonal = &system.diagonal[i];
      const Real upper_neighbours = Real(diagonal[1] > 0) + Real(diagonal[line] > 0) + Real(diagonal[n.high_z] > 0);
      const Pivot<Real> p =
          pivot(*diagonal, share[i - 1], share[i - line], share[i + n.low_z], upper_neighbours, tau, sigma);
      inverse[i] = p.inverse, share[i] = p.share;
    });
  }
  memory.give_back(share);
  return inverse;
}

// What the loop of conjugate gradients does with vectors (common/linear/iterate.h). Of the two triangular solves with
// the factor, the second belongs to the step that uses its result.
struct Steps {
  const System<Real>& system;
  int block;
  const Array<Real>& inverse;

  double dot(std::span<const Real> x, std::span<const Real> y) const {
    return sum_of_planes(system, [&](int plane) {
      double sum = 0;
      ascending(system, plane, [&](std::size_t i) { sum += static_cast<double>(x[i]) * y[i]; });
      return sum;
    });
  }
  void axpy(Real a, std::span<const Real> x, std::span<Real> y) const {
    for_each_cell(system, [&](std::size_t i) { y[i] += a * x[i]; });
  }

  double descend(Real a, std::span<const Real> q, std::span<Real> r) const {
    for_each_cell(system, [&](std::size_t i) { r[i] -= a * q[i]; });
    return dot(r, r);
  }

  // The first triangular solve: z becomes y. Returns r . M^-1 r.
  double precondition(std::span<const Real> r, std::span<Real> z) const {
    const std::ptrdiff_t line = system.cells.line();
    return sum_of_planes(system, [&](int plane) {
      const Neighbours n = neighbours_of(system.cells, block, plane);
      double sum = 0;
      ascending(system, plane, [&](std::size_t i) {
        const Real ey = forward(r[i], z[i - 1], z[i - line], z[i + n.low_z]);
        z[i] = inverse[i] * ey;
        sum += static_cast<double>(ey) * z[i];
      });
      return sum;
    });
  }

  // The second triangular solve, the step and the next direction, and z = A p. Returns p . A p.
  double advance_and_multiply(Real a, Real b, std::span<Real> x, std::span<Real> p, std::span<Real> z) const {
    const std::ptrdiff_t line = system.cells.line();
    for (int plane = system.cells.nz - 1; plane >= 0; --plane) {
      const Neighbours n = neighbours_of(system.cells, block, plane);
      descending(system, plane,
                 [&](std::size_t i) { z[i] = backward(inverse[i], z[i], z[i + 1], z[i + line], z[i + n.high_z]); });
    }
    for_each_cell(system, [&](std::size_t i) {
      x[i] += a * p[i];
      p[i] = z[i] + b * p[i];
    });
    for_each_cell(system, [&](std::size_t i) { z[i] = row_times(system, p.data(), i); });
    return sum_of_planes(system, [&](int plane) {
      double sum = 0;
      descending(system, plane, [&](std::size_t i) { sum += static_cast<double>(p[i]) * z[i]; });
      return sum;
    });
  }
};

// Adds x to the pressure, sets x to 0, and computes the residual of the pressure.
double refresh(const System<Real>& system, const Steps& steps, Array<double>& q, std::span<Real> x, std::span<Real> r) {
  for_each_cell(system, [&](std::size_t i) { q[i] += x[i], x[i] = 0; });
  for_each_cell(system,
                [&](std::size_t i) { r[i] = static_cast<Real>(system.right[i] - row_times(system, q.data(), i)); });
  return steps.dot(r, r);
}

linear::Solution solve(const System<Real>& system, int block, const PressureSettings& settings,
                       PressureMemory<Real>& memory, Array<double>& q) {
  const auto start = start_of(system, settings.guess, memory, q);
  const auto zeros = [&] { return memory.take_zeros(system.cells.size()); };
  Array<Real> inverse = make_inverses(system, block, settings.modification, memory);
  Array<Real> x = zeros(), r = zeros(), z = zeros(), p = zeros();
  const Steps steps{system, block, inverse};
  const linear::System<Real> operators = {
      .multiply = nullptr,
      .precondition = [&](auto r, auto z) { return steps.precondition(r, z); },
      .residual = nullptr,
      .refresh = [&](std::span<Real> x, std::span<Real> r) { return refresh(system, steps, q, x, r); },
      .start = start};
  const linear::Solution solution = linear::iterate(steps, operators, system.right, {x, r, z, p}, settings.stop);
  for (Array<Real>* array : {&inverse, &x, &r, &z, &p}) memory.give_back(*array);
  return solution;
}

}  // namespace

linear::Solution pressure_solve_mic(const System<Real>& system, const PressureSettings& settings,
                                    PressureMemory<Real>& memory, Array<double>& q) {
  return solve(system, std::max(system.cells.nz, 1), settings, memory, q);
}

linear::Solution pressure_solve_block_mic(const System<Real>& system, const PressureSettings& settings,
                                          PressureMemory<Real>& memory, Array<double>& q) {
  return solve(system, planes_of_a_block, settings, memory, q);
}

}  // namespace lockstep::production_fluid::serial
