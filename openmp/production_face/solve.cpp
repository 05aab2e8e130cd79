// The linear system of a step of Newton's method, by conjugate gradients, sixteen elements at a time.
//
// The algorithm stands in serial/production_face/solve.cpp. Products, dot products and updates are linear/'s. The
// inverse of the diagonal is found in the slices of K, a row a lane; it is stored in the order of nodes, as elements of
// vectors stand, so that applying it is a pass over arrays.
//
// The contract stands in common/production_face/solve.h.
#include "common/production_face/solve.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "common/linear/dot.h"
#include "common/linear/multiply.h"
#include "common/linear/update.h"
#include "common/real.h"
#include "common/simd.h"
#include "openmp/whole_vectors.h"

namespace lockstep::production_face::openmp {
namespace {

using linear::SlicedBlockRows;
using lockstep::openmp::Whole;

// The inverse of K's diagonal: two numbers for each element of a vector, those of SymmetricBlock.
struct Preconditioner {
  Array<Real> diagonal, next;
};

Preconditioner invert_diagonal(const SlicedBlockRows& k) {
  const std::size_t n = 3 * static_cast<std::size_t>(k.rows);
  Preconditioner m = {Array<Real>(n), Array<Real>(n)};
  // A slice writes its own rows.
#pragma omp parallel for schedule(static)
  for (int slice = 0; slice < k.slices(); ++slice) {
    const intv row = load(&k.row[slice * lanes]), length = load(&k.length[slice * lanes]);
    SymmetricBlock<floatv> own = {{0.f, 0.f, 0.f}, {0.f, 0.f, 0.f}};
    for (int slot = k.first_slot[slice]; slot < k.first_slot[slice + 1]; ++slot) {
      const intv column = load(&k.column[lanes * static_cast<std::size_t>(slot)]);
      const maskv is_own = (column == row) & (length > intv(slot - k.first_slot[slice]));
      if (none(is_own)) continue;
      const Real* const block = &k.value[9 * lanes * static_cast<std::size_t>(slot)];
      for (int c = 0; c < 3; ++c) {
        where(is_own, own.diagonal[c]) = load(block + lanes * (3 * c + c));
        where(is_own, own.next[c]) = load(block + lanes * (3 * c + (c + 1) % 3));
      }
    }
    const SymmetricBlock<floatv> inverse_block = inverse(own);
    Real diagonal[3][lanes], next[3][lanes];
    for (int c = 0; c < 3; ++c) store(diagonal[c], inverse_block.diagonal[c]), store(next[c], inverse_block.next[c]);
    for (int lane = 0; lane < lanes; ++lane)
      if (const std::ptrdiff_t i = k.row[slice * lanes + lane]; i >= 0)
        for (int c = 0; c < 3; ++c) m.diagonal[3 * i + c] = diagonal[c][lane], m.next[3 * i + c] = next[c][lane];
  }
  return m;
}

// Lanes whose element i + lane is the component `c` of its node.
LOCKSTEP_INLINE maskv lanes_of_component(int c, std::size_t i) {
  constexpr std::uint32_t every_third = 0x49249;
  return lanes_of(every_third << (c + 3 - i % 3) % 3 & 0xffff);
}

// Elements i + lane of an array, of the next component of their nodes, and of the one before. `in` is a mask, or Whole
// where all loads are inside the array.
template <class In>
LOCKSTEP_INLINE floatv load_next(const Real* array, std::size_t i, In in) {
  const maskv is_last = lanes_of_component(2, i);
  return select(is_last, load(array + i - 2, in & is_last), load(array + i + 1, in & !is_last));
}
template <class In>
LOCKSTEP_INLINE floatv load_before(const Real* array, std::size_t i, In in) {
  const maskv is_first = lanes_of_component(0, i);
  return select(is_first, load(array + i + 2, in & is_first), load(array + i - 1, in & !is_first));
}

void apply(const Preconditioner& m, std::span<const Real> r, std::span<Real> z) {
  const std::ptrdiff_t n = r.size();
  const auto row = [&](std::size_t i, auto in) {
    return row_times(load(&m.diagonal[i], in), load(&m.next[i], in), load_before(m.next.data(), i, in), load(&r[i], in),
                     load_next(r.data(), i, in), load_before(r.data(), i, in));
  };
  // An element of z is written by its own iteration alone.
#pragma omp parallel for schedule(static)
  for (std::ptrdiff_t i = 0; i < n; i += lanes) {
    const maskv in = first_lanes(static_cast<int>(std::min<std::ptrdiff_t>(lanes, n - i)));
    if (i >= 2 && i + lanes + 2 <= n)
      store(&z[i], row(i, Whole()));
    else
      store(&z[i], row(i, in), in);
  }
}

// c = a - b.
void subtract(std::span<const Real> a, std::span<const Real> b, std::span<Real> c) {
  // An element is written by its own iteration alone.
#pragma omp parallel for simd schedule(static)
  for (std::size_t i = 0; i < c.size(); ++i) c[i] = a[i] - b[i];
}

using Precondition = std::function<void(std::span<const Real> r, std::span<Real> z)>;

// |b - K x|; leaves b - K x in r.
double residual(const SlicedBlockRows& k, std::span<const Real> b, const Array<double>& x, std::span<Real> r) {
  linear::openmp::residual(k, b, x, r);
  return std::sqrt(linear::openmp::dot(r, r));
}

// Adds x to the sum, and sets it to 0.
void add(std::span<Real> x, Array<double>& sum) {
  // An element is read and written by its own iteration alone.
#pragma omp parallel for simd schedule(static)
  for (std::size_t i = 0; i < x.size(); ++i) sum[i] += x[i], x[i] = 0;
}

// Rounds the sum, and keeps it so.
void round(Array<double>& sum, std::span<Real> x) {
  // An element is read and written by its own iteration alone.
#pragma omp parallel for simd schedule(static)
  for (std::size_t i = 0; i < x.size(); ++i) sum[i] = x[i] = static_cast<Real>(sum[i]);
}

linear::Solution solve(const SlicedBlockRows& k, const Precondition& precondition, std::span<const Real> b,
                       const linear::Stop& stop, std::span<Real> x) {
  Array<double> sum(b.size());
  const linear::System<Real> system = {.multiply =
                                           [&](std::span<const Real> p, std::span<Real> q) {
                                             linear::openmp::multiply(k, p, q);
                                             return linear::openmp::dot(p, q);
                                           },
                                       .precondition =
                                           [&](std::span<const Real> r, std::span<Real> z) {
                                             precondition(r, z);
                                             return linear::openmp::dot(r, z);
                                           },
                                       .residual = nullptr,
                                       .refresh =
                                           [&](std::span<Real> x, std::span<Real> r) {
                                             add(x, sum);
                                             const double norm = residual(k, b, sum, r);
                                             return norm * norm;
                                           }};
  linear::Solution solution = linear::openmp::conjugate_gradients(system, b, x, stop);
  round(sum, x);
  Array<Real> r(b.size());
  if (const double norm = std::sqrt(linear::openmp::dot(b, b)); norm > 0)
    solution.true_residual = residual(k, b, sum, r) / norm;
  return solution;
}

}  // namespace

linear::Solution solve_plain(const SlicedBlockRows& k, std::span<const Real> b, const linear::Stop& stop,
                             std::span<Real> x) {
  const Precondition copy = [](std::span<const Real> r, std::span<Real> z) {
  // An element is copied by its own iteration.
#pragma omp parallel for simd schedule(static)
    for (std::size_t i = 0; i < r.size(); ++i) z[i] = r[i];
  };
  return solve(k, copy, b, stop, x);
}

linear::Solution solve_block_jacobi(const SlicedBlockRows& k, std::span<const Real> b, const linear::Stop& stop,
                                    std::span<Real> x) {
  const Preconditioner m = invert_diagonal(k);
  const Precondition by_blocks = [&](std::span<const Real> r, std::span<Real> z) { apply(m, r, z); };
  return solve(k, by_blocks, b, stop, x);
}

linear::Solution solve_multigrid(const Coarsening<Real>& coarsening, const SlicedBlockRows& k, std::span<const Real> b,
                                 const linear::Stop& stop, std::span<Real> x,
                                 Multigrid<Real, SlicedBlockRows>& memory) {
  Preconditioner m = invert_diagonal(k);
  for (Array<Real>* half : {&m.diagonal, &m.next})
    for (Real& e : *half) e *= Real(damping);
  set_coarse(coarsening, k, memory);
  Array<Real> rest(b.size()), product(b.size());
  const Precondition cycle = [&](std::span<const Real> r, std::span<Real> z) {
    const auto set_rest = [&] {
      linear::openmp::multiply(k, z, product);
      subtract(r, product, rest);
    };
    apply(m, r, z);
    set_rest();
    correct(coarsening, rest, z, memory);
    set_rest();
    apply(m, rest, product);
    linear::openmp::axpy(Real(1), product, z);
  };
  return solve(k, cycle, b, stop, x);
}

}  // namespace lockstep::production_face::openmp
