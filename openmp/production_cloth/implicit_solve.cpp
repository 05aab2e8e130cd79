// A step of linearised backward Euler: the matrix, and conjugate gradients.
//
// The algorithm stands in serial/production_cloth/implicit_solve.cpp. Elements that share a vertex would write the same
// blocks, so assembly falls into two passes. First, sixteen elements at a time store their shares. Then each row adds
// up the shares of its blocks, those of links, membranes and hinges in their order: the serial sums.
//
// A share is stored for the block above the diagonal, and the block below it reads the same: A is symmetric to the bit.
//
// The contract stands in common/production_cloth/implicit_solve.h.
#include "common/production_cloth/implicit_solve.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/linear/dot.h"
#include "common/linear/multiply.h"
#include "common/production_cloth/forces.h"
#include "common/real.h"
#include "common/simd.h"
#include "openmp/vector_lanes.h"

namespace lockstep::production_cloth::openmp {
namespace {

using Matrix = linear::SlicedBlockRows;
using Memory = OpenmpImplicitMemory;

// Shares are prefetched so many before their turn, about two rows: the processor does not foresee their order.
constexpr int ahead = 24;

// The entries that a transposition exchanges.
constexpr std::pair<int, int> off_diagonal[] = {{1, 3}, {2, 6}, {5, 7}};

Vector3<floatv> load_at(const Vectors<Real>& v, intv index) {
  return {gather(v.x.data(), index), gather(v.y.data(), index), gather(v.z.data(), index)};
}
Vector3<floatv> load_at(const Vectors<Real>& v, intv index, maskv mask) {
  return {gather(v.x.data(), index, mask), gather(v.y.data(), index, mask), gather(v.z.data(), index, mask)};
}

Blocks<floatv, 1> stiffness_of_links(const Elements<Real>& elements, const Vectors<Real>& position,
                                     const Scales<floatv>& scales, int k) {
  const Vector3<floatv> d = load_at(position, load(&elements.to[k])) - load_at(position, load(&elements.from[k]));
  Block<floatv> block = on_diagonal(floatv(0.f));
  if (elements.has_bending)
    block = stiffness_of_bending(scales, floatv(elements.bend_damping), load(&elements.bending[k]));
  if (elements.has_springs && k < elements.edges) {
    const Block<floatv> sum =
        block + stiffness_of_spring(scales, load(&elements.rest_length[k]), load(&elements.spring[k]),
                                    load(&elements.root_of_damping[k]), d);
    for (int i = 0; i < 9; ++i) where(first_lanes(elements.edges - k), block.e[i]) = sum.e[i];
  }
  return {{block}};
}

Blocks<floatv, membrane_pairs> stiffness_of_membranes(const Elements<Real>& elements, const Vectors<Real>& position,
                                                      const Scales<floatv>& scales, int block) {
  const auto x = [&](int c) { return load_at(position, load(elements.membrane_corner.vector(block, c))); };
  const Vector3<floatv> x0 = x(0), x1 = x(1), x2 = x(2);
  const Membrane<floatv> m =
      membrane_of<floatv>(elements, [&](const Blocked<Real>& array, int f) { return load(array.vector(block, f)); });
  return blocks_of_membrane(m, stress_derivative(elements, scales, deformation_of(m, x1 - x0, x2 - x0)));
}

Blocks<floatv, hinge_pairs> stiffness_of_hinges(const Elements<Real>& elements, const Vectors<Real>& position,
                                                const Scales<floatv>& scales, int block) {
  const auto x = [&](int c) { return load_at(position, load(elements.hinge_corner.vector(block, c))); };
  return blocks_of_hinge(scales, floatv(elements.hinge_stiffness), load(elements.hinge.vector(block, 1)),
                         fold_of(x(0), x(1), x(2), x(3)));
}

// Transposes the blocks whose first corner has the greater number, so that all stand above the diagonal of the matrix.
template <int pairs>
void turn_upward(const Blocked<std::int32_t>& corner, int block, const int (&pair)[pairs][2],
                 Blocks<floatv, pairs>& blocks) {
  for (int p = 0; p < pairs; ++p) {
    const maskv below = load(corner.vector(block, pair[p][0])) > load(corner.vector(block, pair[p][1]));
    floatv(&e)[9] = blocks.of[p].e;
    for (const auto& [i, j] : off_diagonal) {
      const floatv above = select(below, e[j], e[i]);
      e[j] = select(below, e[i], e[j]), e[i] = above;
    }
  }
}

// An element's shares stand side by side; those of sixteen elements begin at share `first`.
template <int pairs>
void store_shares(const Blocks<floatv, pairs>& blocks, int first, Array<Real>& shares) {
  constexpr int numbers = 9 * pairs;
  Real* const to = &shares[9 * static_cast<std::size_t>(first)];
  for (int i = 0; i < numbers; i += lanes) {
    const int count = std::min(numbers - i, lanes);
    floatv row[lanes];
    for (int l = 0; l < lanes; ++l) row[l] = l < count ? blocks.of[(i + l) / 9].e[(i + l) % 9] : floatv(0.f);
    transpose(row);
    for (int l = 0; l < lanes; ++l) store(to + numbers * l + i, row[l], first_lanes(count));
  }
}

// The blocks of a row; entry e of block i goes to to[16 (9 i + e)]. Columns ascend. Lanes 0 to 8 are the entries, those
// of the transpose left of the diagonal.
void add_up_row(int row, Real mass, Memory& memory, Real* to) {
  const Pattern& pattern = memory.pattern;
  const auto store_block = [&](int place, const Real* block, bool is_transposed) {
    Real* const first = to + 9 * lanes * (place - pattern.begin[row]);
    for (int r = 0; r < 3; ++r)
      for (int s = 0; s < 3; ++s) first[lanes * (3 * r + s)] = block[is_transposed ? 3 * s + r : 3 * r + s];
  };
  const auto share = [&](int s) { return &memory.shares[9 * static_cast<std::size_t>(pattern.share[s])]; };
  const int last = static_cast<int>(pattern.share.size()) - 1;
  floatv left = 0.f, right = 0.f;
  int own = 0;
  for (int place = pattern.begin[row]; place < pattern.begin[row + 1]; ++place) {
    floatv block = 0.f;
    for (int s = pattern.first_share[place]; s < pattern.first_share[place + 1]; ++s) {
      __builtin_prefetch(share(std::min(s + ahead, last)));
      block += load(share(s));
    }
    if (pattern.column[place] == row) own = place;
    const bool is_left = pattern.column[place] < row;
    (is_left ? left : right) += block;
    Real entry[lanes];
    store(entry, block);
    store_block(place, entry, is_left);
  }
  Real of_left[lanes], of_right[lanes];
  store(of_left, left), store(of_right, right);
  Block<Real> sum_left, sum_right;
  std::copy_n(of_left, 9, sum_left.e), std::copy_n(of_right, 9, sum_right.e);
  const Block<Real> block = diagonal_block(mass, transposed(sum_left), sum_right);
  store_block(own, block.e, false);
  std::ranges::copy(block.e, &memory.diagonal[9 * static_cast<std::size_t>(row)]);
}

Block<floatv> block_at(const Array<Real>& values, std::size_t slot) {
  Block<floatv> block;
  for (int i = 0; i < 9; ++i) block.e[i] = load(&values[lanes * (9 * slot + i)]);
  return block;
}

void invert_diagonal(Memory& memory) {
  Matrix& m = memory.inverse;
  // A slice writes its own rows. Lanes without a row invert the block of row 0; nobody reads the result.
#pragma omp parallel for schedule(static)
  for (int slice = 0; slice < m.slices(); ++slice)
    for (std::size_t slot = m.first_slot[slice]; slot < std::size_t(m.first_slot[slice + 1]); ++slot) {
      Block<floatv> own;
      for (int i = 0; i < 9; ++i) own.e[i] = gather(&memory.diagonal[i], load(&m.column[lanes * slot]) * intv(9));
      const Block<floatv> inverse = inverse_of_definite(own);
      for (int i = 0; i < 9; ++i) store(&m.value[lanes * (9 * slot + i)], inverse.e[i]);
    }
}

// b = h f - (A - M) v; 0 in rows of held vertices.
void set_right_side(const Matrix& a, Real time_step, const Vectors<Real>& force, const Vectors<Real>& velocity,
                    Array<Real>& b) {
  // A slice writes its own rows of b alone.
#pragma omp parallel for schedule(static)
  for (int slice = 0; slice < a.slices(); ++slice) {
    const intv i = load(&a.row[slice * lanes]), length = load(&a.length[slice * lanes]);
    const maskv is_free = length > intv(0);
    const Vector3<floatv> own = load_at(velocity, i, is_free);
    Vector3<floatv> rest = time_step * load_at(force, i, is_free);
    for (int slot = a.first_slot[slice]; slot < a.first_slot[slice + 1]; ++slot) {
      const maskv active = length > intv(slot - a.first_slot[slice]);
      const intv column = load(&a.column[lanes * static_cast<std::size_t>(slot)]);
      rest = select(active, rest - block_at(a.value, slot) * (load_at(velocity, column, active) - own), rest);
    }
    Real to[3][lanes];
    store(to[0], rest.x), store(to[1], rest.y), store(to[2], rest.z);
    for (int l = 0; l < lanes; ++l)
      if (const std::ptrdiff_t row = a.row[slice * lanes + l]; row >= 0)
        for (int c = 0; c < 3; ++c) b[3 * row + c] = to[c][l];
  }
}

}  // namespace

Memory make_implicit_memory(const Elements<Real>& elements, const Array<Real>& inverse_mass) {
  Memory memory;
  memory.pattern = make_pattern(elements, inverse_mass);
  memory.matrix = linear::slice(make_block_rows<Real>(memory.pattern));
  memory.inverse = linear::slice(make_diagonal_block_rows<Real>(memory.pattern));
  const std::size_t n = elements.vertices;
  memory.diagonal.resize(9 * n), memory.b.resize(3 * n), memory.x.resize(3 * n);
  memory.shares.resize(9 * static_cast<std::size_t>(memory.pattern.shares) + lanes);
  return memory;
}

void assemble(const Elements<Real>& elements, const Vectors<Real>& position, const Array<Real>& mass, Real time_step,
              Memory& memory) {
  const Scales<floatv> scales = {time_step * time_step, time_step};
  const Pattern& pattern = memory.pattern;
  Matrix& a = memory.matrix;
#pragma omp parallel
  {
    // Sixteen links write their own shares; likewise membranes and hinges.
#pragma omp for schedule(static) nowait
    for (int k = 0; k < elements.links; k += lanes)
      store_shares(stiffness_of_links(elements, position, scales, k), pattern.of_link(k), memory.shares);
      // See above.
#pragma omp for schedule(static) nowait
    for (int block = 0; block < elements.membrane_corner_blocks(); ++block) {
      Blocks<floatv, membrane_pairs> blocks = stiffness_of_membranes(elements, position, scales, block);
      turn_upward(elements.membrane_corner, block, membrane_pair, blocks);
      store_shares(blocks, pattern.of_membrane(lanes * block), memory.shares);
    }
    // See above.
#pragma omp for schedule(static)
    for (int block = 0; block < elements.hinge_corner_blocks(); ++block) {
      Blocks<floatv, hinge_pairs> blocks = stiffness_of_hinges(elements, position, scales, block);
      turn_upward(elements.hinge_corner, block, hinge_pair, blocks);
      store_shares(blocks, pattern.of_hinge(lanes * block), memory.shares);
    }
    // A slice writes its own rows, and reads shares that nobody writes any more.
#pragma omp for schedule(static)
    for (int slice = 0; slice < a.slices(); ++slice)
      for (int lane = 0; lane < lanes; ++lane)
        if (const int row = a.row[slice * lanes + lane]; row >= 0 && pattern.begin[row] < pattern.begin[row + 1])
          add_up_row(row, mass[row], memory,
                     &a.value[9 * lanes * static_cast<std::size_t>(a.first_slot[slice]) + lane]);
  }
}

linear::Solution implicit_solve(const Elements<Real>& elements, const Vectors<Real>& position, const Array<Real>& mass,
                                Real time_step, const Vectors<Real>& force, const linear::Stop& stop,
                                Vectors<Real>& velocity, Memory& memory) {
  assemble(elements, position, mass, time_step, memory);
  invert_diagonal(memory);
  set_right_side(memory.matrix, time_step, force, velocity, memory.b);

  const auto multiply = [&](std::span<const Real> p, std::span<Real> q) {
    linear::openmp::multiply(memory.matrix, p, q);
    return linear::openmp::dot(p, q);
  };
  const auto precondition = [&](std::span<const Real> r, std::span<Real> z) {
    linear::openmp::multiply(memory.inverse, r, z);
    return linear::openmp::dot(r, z);
  };
  const linear::Solution solution =
      linear::openmp::conjugate_gradients({multiply, precondition, nullptr}, memory.b, memory.x, stop);

  // A vertex is written by its own iteration alone.
#pragma omp parallel for simd schedule(static)
  for (int i = 0; i < elements.vertices; ++i) {
    const Real* const x = &memory.x[3 * static_cast<std::size_t>(i)];
    store(velocity, i, load(velocity, i) + Vector3<Real>{x[0], x[1], x[2]});
  }
  return solution;
}

}  // namespace lockstep::production_cloth::openmp
