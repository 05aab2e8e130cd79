// Contract: a step of linearised backward Euler: elastic forces and damping of the step's end, both linearised at its
// start.
//
//   M dv = h (f(x) + df/dx h (v + dv) - D (v + dv)),   so   A dv = h f - (A - M) v,   A = M + h D + h^2 K
//
// for the vertices that are free; K is the definite part of -df/dx, element by element (element_stiffness.h), D the
// damping at x. Those that are held keep their velocity, which moves the others. Blocks of a row of A - M sum to 0, so
// that (A - M) v is a sum of A_ij (v_j - v_i): nothing changes in free fall, whatever rounding does.
//
// A is assembled as 3x3 block rows, symmetric to the bit, and the system solved by conjugate gradients
// (common/linear/conjugate_gradients.h) with block Jacobi. The tolerance is of the right-hand side above, which does
// not depend on how fast the cloth moves as a whole. In float, r falls to any tolerance, and the true residual stays at
// about 2^-24 |A| |dv|.
//
// A is definite but for rounding: diagonal blocks are sums of the others of their row, off by 2^-24 of these. M covers
// that as long as h^2 |K| < 2^24 M, about. Where it does not, a solve may end early, and its residual says so.
//
// In:      elements; position, m; mass, kg; time_step, s: h; force, N: the elastic forces at `position`; when to stop.
// In, out: velocity, m/s: v, v + dv. Forces that depend on neither place nor velocity, such as gravity, may be added
//          before: v + h g gives the same v + dv as they would in f.
// Scratch: memory, made for the elements and the vertices that are held; A, its right-hand side and dv stay there.
// Returns: the iterations and the recursive residual; the true one is not computed.
// Errors:  std::bad_alloc; make_implicit_memory: std::length_error, too (make_pattern).
// Arrays are padded.
//
// Source: Baraff and Witkin, Large steps in cloth simulation, SIGGRAPH 1998; [ITJ07] "Production Cloth".
#pragma once

#include "common/linear/conjugate_gradients.h"
#include "common/linear/sliced.h"
#include "common/production_cloth/pattern.h"

namespace lockstep::production_cloth {

// Vectors of the solve hold component c of vertex v at 3 v + c.
template <class Real, class Matrix>
struct ImplicitMemory {
  Pattern pattern;
  Matrix matrix;         // A; rows of held vertices are empty, their columns are not
  Matrix inverse;        // of its diagonal blocks, as a matrix
  Array<Real> diagonal;  // [9 v + e]: the diagonal blocks
  Array<Real> b, x;      // the right-hand side; dv
  Array<Real> shares;    // openmp: [9 share + e], and room behind the last for a load of sixteen
};
using SerialImplicitMemory = ImplicitMemory<float, linear::BlockRows<float>>;
using OpenmpImplicitMemory = ImplicitMemory<float, linear::SlicedBlockRows>;

// Sets memory.matrix and memory.diagonal.
template <class Real, class Matrix>
using Assemble = void(const Elements<Real>& elements, const Vectors<Real>& position, const Array<Real>& mass,
                      Real time_step, ImplicitMemory<Real, Matrix>& memory);

template <class Real, class Matrix>
using ImplicitSolve = linear::Solution(const Elements<Real>& elements, const Vectors<Real>& position,
                                       const Array<Real>& mass, Real time_step, const Vectors<Real>& force,
                                       const linear::Stop& stop, Vectors<Real>& velocity,
                                       ImplicitMemory<Real, Matrix>& memory);

// inverse_mass: 0 of held vertices.
namespace serial {
ImplicitMemory<float, linear::BlockRows<float>> make_implicit_memory(const Elements<float>& elements,
                                                                     const Array<float>& inverse_mass);
ImplicitMemory<double, linear::BlockRows<double>> make_implicit_memory(const Elements<double>& elements,
                                                                       const Array<double>& inverse_mass);
Assemble<float, linear::BlockRows<float>> assemble;
Assemble<double, linear::BlockRows<double>> assemble;
ImplicitSolve<float, linear::BlockRows<float>> implicit_solve;
ImplicitSolve<double, linear::BlockRows<double>> implicit_solve;
}  // namespace serial

namespace openmp {
OpenmpImplicitMemory make_implicit_memory(const Elements<float>& elements, const Array<float>& inverse_mass);
Assemble<float, linear::SlicedBlockRows> assemble;
ImplicitSolve<float, linear::SlicedBlockRows> implicit_solve;
}  // namespace openmp

// --- Formulas; of a number or of lanes

// dP of dF of membranes whose F is f, elastic and of damping.
template <class T, class Real>
inline StressDerivative<T> stress_derivative(const Elements<Real>& elements, const Scales<T>& scales,
                                             const Columns<T>& f) {
  const T lambda(elements.lambda), mu(elements.mu);
  const T damping = scales.step * T(elements.membrane_damping),
          strain = elements.corotated ? damping : scales.square + damping;
  const StressDerivative<T> by_rate = by_strain(strain * lambda, strain * mu, f);
  const StressDerivative<T> other = elements.corotated
                                        ? corotated_derivative(scales.square * lambda, scales.square * mu, f)
                                        : by_turning_of_stress(scales.square * lambda, scales.square * mu, f);
  return {by_rate.xx + other.xx, by_rate.xy + other.xy, by_rate.yy + other.yy};
}

// A diagonal block of A, from the vertex's mass and the sums of the blocks to its left and to its right in its row,
// with the upper triangle in both halves.
template <class T>
inline Block<T> diagonal_block(const T& mass, const Block<T>& left, const Block<T>& right) {
  Block<T> block;
  for (int r = 0; r < 3; ++r)
    for (int s = r; s < 3; ++s) {
      const T sum = -(left.e[3 * r + s] + right.e[3 * r + s]);
      block.e[3 * r + s] = block.e[3 * s + r] = r == s ? mass + sum : sum;
    }
  return block;
}

// The inverse of a diagonal block, from its factors L D L^T. Exact pivots are at least the mass. One that rounding
// makes smaller than 2^-20 of its diagonal entry counts as that, so that the inverse is definite.
template <class T>
inline Block<T> inverse_of_definite(const Block<T>& a) {
  const T least(0x1p-20f), one(1);
  const T pivot0 = a.e[0], l10 = a.e[1] / pivot0, l20 = a.e[2] / pivot0;
  const T pivot1 = max(a.e[4] - l10 * a.e[1], least * a.e[4]), rest12 = a.e[5] - l10 * a.e[2], l21 = rest12 / pivot1;
  const T pivot2 = max(a.e[8] - l20 * a.e[2] - l21 * rest12, least * a.e[8]);
  // L^-1 has -l10, m20 and -l21.
  const T m20 = l10 * l21 - l20, d0 = one / pivot0, d1 = one / pivot1, d2 = one / pivot2;
  const T xx = d0 + (l10 * l10 * d1 + m20 * m20 * d2), xy = -(l10 * d1 + m20 * l21 * d2), xz = m20 * d2,
          yy = d1 + l21 * l21 * d2, yz = -(l21 * d2);
  return {{xx, xy, xz, xy, yy, yz, xz, yz, d2}};
}

}  // namespace lockstep::production_cloth
