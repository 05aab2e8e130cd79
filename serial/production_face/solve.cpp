// The linear system of a step of Newton's method, by conjugate gradients.
//
// K is large, sparse and symmetric, and definite once strains have been made so. A product with it costs one pass over
// its blocks, and conjugate gradients need nothing else of it: no factor has to be computed anew as K changes. The
// number of products falls if each node's forces are first turned into the displacements that they would cause were
// all other nodes held, which is the inverse of the node's block on the diagonal: block Jacobi. Nodes do not
// wait for one another there. Held nodes have a block of 0, and stay where they are.
//
// Flesh hardly changes its volume, so that its nodes' forces are small differences of large products: in float alone,
// x would not come near the tolerance that its recursive residual claims. So x is a sum in double, of which the loop
// computes its residual anew from time to time.
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

namespace lockstep::production_face::serial {
namespace {

using linear::BlockRows;

// The inverse of K's diagonal: two numbers for each element of a vector, those of SymmetricBlock.
struct Preconditioner {
  Array<Real> diagonal, next;
};

Preconditioner invert_diagonal(const BlockRows<Real>& k) {
  const std::size_t n = 3 * static_cast<std::size_t>(k.rows);
  Preconditioner m = {Array<Real>(n), Array<Real>(n)};
  for (int i = 0; i < k.rows; ++i) {
    SymmetricBlock<Real> own = {};
    for (int place = k.begin[i]; place < k.begin[i + 1]; ++place) {
      if (k.column[place] != i) continue;
      const Real* const block = &k.value[9 * static_cast<std::size_t>(place)];
      for (int c = 0; c < 3; ++c) own.diagonal[c] = block[3 * c + c], own.next[c] = block[3 * c + (c + 1) % 3];
    }
    const SymmetricBlock<Real> inverse_block = inverse(own);
    for (int c = 0; c < 3; ++c) {
      m.diagonal[3 * static_cast<std::size_t>(i) + c] = inverse_block.diagonal[c];
      m.next[3 * static_cast<std::size_t>(i) + c] = inverse_block.next[c];
    }
  }
  return m;
}

void apply(const Preconditioner& m, std::span<const Real> r, std::span<Real> z) {
  for (std::size_t i = 0; i < r.size(); ++i) {
    const std::size_t next = i % 3 == 2 ? i - 2 : i + 1, before = i % 3 == 0 ? i + 2 : i - 1;
    z[i] = row_times(m.diagonal[i], m.next[i], m.next[before], r[i], r[next], r[before]);
  }
}

// c = a - b.
void subtract(std::span<const Real> a, std::span<const Real> b, std::span<Real> c) {
  for (std::size_t i = 0; i < c.size(); ++i) c[i] = a[i] - b[i];
}

using Precondition = std::function<void(std::span<const Real> r, std::span<Real> z)>;

// |b - K x|; leaves b - K x in r.
double residual(const BlockRows<Real>& k, std::span<const Real> b, const Array<double>& x, std::span<Real> r) {
  linear::serial::residual(k, b, x, r);
  return std::sqrt(linear::serial::dot(r, r));
}

// Adds x to the sum, and sets it to 0.
void add(std::span<Real> x, Array<double>& sum) {
  for (std::size_t i = 0; i < x.size(); ++i) sum[i] += x[i], x[i] = 0;
}

// Rounds the sum, and keeps it so.
void round(Array<double>& sum, std::span<Real> x) {
  for (std::size_t i = 0; i < x.size(); ++i) sum[i] = x[i] = static_cast<Real>(sum[i]);
}

linear::Solution solve(const BlockRows<Real>& k, const Precondition& precondition, std::span<const Real> b,
                       const linear::Stop& stop, std::span<Real> x) {
  Array<double> sum(b.size());
  const linear::System<Real> system = {.multiply =
                                           [&](std::span<const Real> p, std::span<Real> q) {
                                             linear::serial::multiply(k, p, q);
                                             return linear::serial::dot(p, q);
                                           },
                                       .precondition =
                                           [&](std::span<const Real> r, std::span<Real> z) {
                                             precondition(r, z);
                                             return linear::serial::dot(r, z);
                                           },
                                       .residual = nullptr,
                                       .refresh =
                                           [&](std::span<Real> x, std::span<Real> r) {
                                             add(x, sum);
                                             const double norm = residual(k, b, sum, r);
                                             return norm * norm;
                                           }};
  linear::Solution solution = linear::serial::conjugate_gradients(system, b, x, stop);
  round(sum, x);
  Array<Real> r(b.size());
  if (const double norm = std::sqrt(linear::serial::dot(b, b)); norm > 0)
    solution.true_residual = residual(k, b, sum, r) / norm;
  return solution;
}

}  // namespace

linear::Solution solve_plain(const BlockRows<Real>& k, std::span<const Real> b, const linear::Stop& stop,
                             std::span<Real> x) {
  const Precondition copy = [](std::span<const Real> r, std::span<Real> z) { std::ranges::copy(r, z.begin()); };
  return solve(k, copy, b, stop, x);
}

linear::Solution solve_block_jacobi(const BlockRows<Real>& k, std::span<const Real> b, const linear::Stop& stop,
                                    std::span<Real> x) {
  const Preconditioner m = invert_diagonal(k);
  const Precondition by_blocks = [&](std::span<const Real> r, std::span<Real> z) { apply(m, r, z); };
  return solve(k, by_blocks, b, stop, x);
}

linear::Solution solve_multigrid(const Coarsening<Real>& coarsening, const BlockRows<Real>& k, std::span<const Real> b,
                                 const linear::Stop& stop, std::span<Real> x,
                                 Multigrid<Real, BlockRows<Real>>& memory) {
  Preconditioner m = invert_diagonal(k);
  for (Array<Real>* half : {&m.diagonal, &m.next})
    for (Real& e : *half) e *= Real(damping);
  set_coarse(coarsening, k, memory);
  Array<Real> rest(b.size()), product(b.size());
  const Precondition cycle = [&](std::span<const Real> r, std::span<Real> z) {
    const auto set_rest = [&] {
      linear::serial::multiply(k, z, product);
      subtract(r, product, rest);
    };
    apply(m, r, z);
    set_rest();
    correct(coarsening, rest, z, memory);
    set_rest();
    apply(m, rest, product);
    linear::serial::axpy(Real(1), product, z);
  };
  return solve(k, cycle, b, stop, x);
}

}  // namespace lockstep::production_face::serial
