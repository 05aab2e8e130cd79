// Contract: the pressure of a system (system.h), by preconditioned conjugate gradients.
//
//   mic   preconditioned by the modified incomplete Cholesky factor, M = (E + L) E^-1 (E + L)^T. L is the matrix below
//         its diagonal, E is diagonal: for cell c with lower neighbours l (along -x, -y and -z),
//
//           e(c) = diagonal(c) - sum over l of share(l)
//           share(l) = (1 + tau (upper neighbours of l other than c)) / e(l)
//           e(c) = diagonal(c) in place of any e(c) < sigma diagonal(c)
//
//         and M z = r by  y(c) = (r(c) + sum of y over lower neighbours) / e(c), cells ascending,
//                         z(c) = y(c) + (sum of z over upper neighbours) / e(c), cells descending.
//
//         serial goes through the cells in order. openmp goes along wavefronts (openmp/production_fluid/skewed.h): each
//         cell reads the same values as in order.
//   block_mic
//         the same with one factor for each sixteen planes along z: neighbours in another block do not count. Blocks do
//         not wait for one another, and do not depend on the number of threads; the price is more iterations.
//   multigrid
//         preconditioned by a V-cycle (multigrid.h). The modification does not matter. Both versions keep the cells in
//         their order, and sum as common/linear/dot.h says, over bordered arrays.
//
// A dot product of mic and block_mic is summed in double, in an order that does not depend on the threads: the products
// of a plane's cells in ascending order; sixteen planes, z = 16 k to 16 k + 15, in the tree ((0 + 8) + (4 + 12)) + ...;
// and such sixteens in ascending order. r . z of mic and block_mic is the sum of (e y) y, as r . M^-1 r = y . E y: the
// first triangular solve adds it up on its way. p . A p is summed likewise, but the products of a plane in descending
// order: openmp computes A p behind the second triangular solve, which goes that way.
//
// The loop is linear/'s (common/linear/conjugate_gradients.h). It works in Real. The pressure is a sum in double, from
// which the loop refreshes its residual.
//
// The sum may begin with a guess, from the q of an earlier solve on this grid times a factor. Each row is solved for
// its own unknown, where the others have that value: a Jacobi step, without which rows beside the surface, whose
// diagonals change most, would leave residuals several times as large as b. A guess that leaves more than b is dropped.
//
// In:     system; modification: tau and sigma; when to stop; what q is multiplied by to be a guess.
// In, out: q. With a factor of 0, or another size than the system's, it is no guess and may hold anything.
// Out:    q, bordered as the system is, m/s; 0 in cells without a row. In a pocket it is known up to a constant.
// Scratch: memory. What earlier solves have left there, of whatever system, changes nothing.
// Returns the iterations and both residuals.
// Source: [ITJ07] "Production Fluid"; Bridson, Fluid Simulation for Computer Graphics (2nd ed., 2015), 5.3. A factor a
//         block: as PhysBAM's threads have it, each its own block.
#pragma once

#include "common/linear/conjugate_gradients.h"
#include "common/linear/incomplete_cholesky.h"
#include "common/math.h"
#include "common/production_fluid/pressure_memory.h"
#include "common/production_fluid/system.h"

namespace lockstep::production_fluid {

struct PressureSettings {
  linear::Modification modification;
  linear::Stop stop;
  double guess = 0;  // what q is multiplied by
};

template <class Real>
using PressureSolve = linear::Solution(const System<Real>& system, const PressureSettings& settings,
                                       PressureMemory<Real>& memory, Array<double>& q);

namespace serial {
PressureSolve<float> pressure_solve_mic, pressure_solve_block_mic, pressure_solve_multigrid;
PressureSolve<double> pressure_solve_mic, pressure_solve_block_mic, pressure_solve_multigrid;
}  // namespace serial

namespace openmp {
PressureSolve<float> pressure_solve_mic, pressure_solve_block_mic, pressure_solve_multigrid;
}  // namespace openmp

inline constexpr int planes_of_a_sum = 16;
inline constexpr int planes_of_a_block = 16;

// --- Formulas; of numbers or of lanes

// y(x) of y = A x.
template <class Number>
inline Number product(const Number& diagonal, const Number& here, const Number& low_x, const Number& high_x,
                      const Number& low_y, const Number& high_y, const Number& low_z, const Number& high_z) {
  return diagonal * here - (((low_x + high_x) + (low_y + high_y)) + (low_z + high_z));
}

// What a row is solved by, where the others have `factor` times the q of before. Reads at the row's own place and its
// neighbours' ones.
template <class Real>
inline double guess_of_row(const Real* diagonal, const Real* right, const double* before, double factor,
                           std::ptrdiff_t line, std::ptrdiff_t plane) {
  const auto at = [&](std::ptrdiff_t to) { return diagonal[to] > 0 ? before[to] : 0.; };
  const double beside = ((at(-1) + at(1)) + (at(-line) + at(line))) + (at(-plane) + at(plane));
  return (*right + factor * beside) / *diagonal;
}

// 1 / e of a cell, and its share in each upper neighbour; both 0 where the diagonal is 0.
template <class Number>
struct Pivot {
  Number inverse, share;
};
template <class Number>
inline Pivot<Number> pivot(const Number& diagonal, const Number& low_x, const Number& low_y, const Number& low_z,
                           const Number& upper_neighbours, const Number& tau, const Number& sigma) {
  const Number e = ((diagonal - low_x) - low_y) - low_z;
  const Number safe = select(e < sigma * diagonal, diagonal, e);
  const auto row = diagonal > Number(0);
  const Number inverse = select(row, Number(1) / safe, Number(0));
  return {inverse, select(row, (Number(1) + tau * (upper_neighbours - Number(1))) * inverse, Number(0))};
}

// e y of a cell.
template <class Number>
inline Number forward(const Number& r, const Number& low_x, const Number& low_y, const Number& low_z) {
  return ((r + low_y) + low_z) + low_x;
}
// z of a cell.
template <class Number>
inline Number backward(const Number& inverse, const Number& y, const Number& high_x, const Number& high_y,
                       const Number& high_z) {
  return y + inverse * ((high_y + high_z) + high_x);
}

}  // namespace lockstep::production_fluid
