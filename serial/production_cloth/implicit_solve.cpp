// A step of linearised backward Euler: the matrix, element by element, and conjugate gradients.
//
// Explicit elastic forces bound the step by the highest frequency of the cloth. Taken at the step's end instead, they
// do not, and the step is a linear system: mass, damping and stiffness, of which each element knows a block for each
// two of its corners. Where the blocks stand has been found once (pattern.h). Where all vertices move alike no force
// changes, so that a diagonal block is the mass less the sum of the other blocks of its row.
//
// Stiffness is most of the diagonal at long steps, and is of another size along the cloth than across it. So the
// inverse of each vertex's 3x3 block is the preconditioner.
//
// Held vertices are filtered: their rows are empty, and their velocities act by the right-hand side.
//
// The contract stands in common/production_cloth/implicit_solve.h.
#include "common/production_cloth/implicit_solve.h"

#include <algorithm>
#include <cmath>

#include "common/linear/dot.h"
#include "common/linear/multiply.h"
#include "common/production_cloth/forces.h"
#include "common/real.h"

namespace lockstep::production_cloth::serial {
namespace {

using Matrix = linear::BlockRows<Real>;
using Memory = ImplicitMemory<Real, Matrix>;

Block<Real> stiffness_of_link(const Elements<Real>& elements, const Vectors<Real>& position, const Scales<Real>& scales,
                              int k) {
  const Vector3<Real> d = load(position, elements.to[k]) - load(position, elements.from[k]);
  Block<Real> block = {};
  if (elements.has_bending) block = stiffness_of_bending(scales, elements.bend_damping, elements.bending[k]);
  if (elements.has_springs && k < elements.edges)
    block = block +
            stiffness_of_spring(scales, elements.rest_length[k], elements.spring[k], elements.root_of_damping[k], d);
  return block;
}

Blocks<Real, membrane_pairs> stiffness_of_membrane(const Elements<Real>& elements, const Vectors<Real>& position,
                                                   const Scales<Real>& scales, int t) {
  const auto x = [&](int c) { return load(position, elements.membrane_corner.at(t, c)); };
  const Vector3<Real> x0 = x(0), x1 = x(1), x2 = x(2);
  const Membrane<Real> m =
      membrane_of<Real>(elements, [&](const Blocked<Real>& array, int f) { return array.at(t, f); });
  return blocks_of_membrane(m, stress_derivative(elements, scales, deformation_of(m, x1 - x0, x2 - x0)));
}

Blocks<Real, hinge_pairs> stiffness_of_hinge(const Elements<Real>& elements, const Vectors<Real>& position,
                                             const Scales<Real>& scales, int h) {
  const auto x = [&](int c) { return load(position, elements.hinge_corner.at(h, c)); };
  return blocks_of_hinge(scales, elements.hinge_stiffness, elements.hinge.at(h, 1), fold_of(x(0), x(1), x(2), x(3)));
}

// Adds a share to the blocks of its two corners.
void add_share(const Pattern& pattern, int share, const Block<Real>& block, Matrix& a) {
  const auto add = [&](std::ptrdiff_t place, const Block<Real>& e) {
    if (place >= 0)
      for (int i = 0; i < 9; ++i) a.value[9 * place + i] += e.e[i];
  };
  add(pattern.place[2 * static_cast<std::size_t>(share)], block);
  add(pattern.place[2 * static_cast<std::size_t>(share) + 1], transposed(block));
}

// The diagonal block of a row. Columns ascend.
void add_up_row(int row, Real mass, Memory& memory) {
  Matrix& a = memory.matrix;
  Block<Real> left = {}, right = {};
  int own = 0;
  for (int place = a.begin[row]; place < a.begin[row + 1]; ++place) {
    if (a.column[place] == row) own = place;
    Block<Real>& sum = a.column[place] < row ? left : right;
    for (int i = 0; i < 9; ++i) sum.e[i] += a.value[9 * static_cast<std::size_t>(place) + i];
  }
  const Block<Real> block = diagonal_block(mass, left, right);
  std::ranges::copy(block.e, &a.value[9 * static_cast<std::size_t>(own)]);
  std::ranges::copy(block.e, &memory.diagonal[9 * static_cast<std::size_t>(row)]);
}

Block<Real> block_at(const Array<Real>& values, std::size_t place) {
  Block<Real> block;
  std::copy_n(&values[9 * place], 9, block.e);
  return block;
}

void invert_diagonal(Memory& memory) {
  Matrix& m = memory.inverse;
  for (int i = 0; i < m.rows; ++i)
    for (std::size_t place = m.begin[i]; place < std::size_t(m.begin[i + 1]); ++place)
      std::ranges::copy(inverse_of_definite(block_at(memory.diagonal, i)).e, &m.value[9 * place]);
}

// b = h f - (A - M) v; 0 in rows of held vertices.
void set_right_side(const Matrix& a, Real time_step, const Vectors<Real>& force, const Vectors<Real>& velocity,
                    Array<Real>& b) {
  for (int i = 0; i < a.rows; ++i) {
    Vector3<Real> rest = {0, 0, 0};
    if (a.begin[i] < a.begin[i + 1]) rest = time_step * load(force, i);
    for (int place = a.begin[i]; place < a.begin[i + 1]; ++place)
      rest = rest - block_at(a.value, place) * (load(velocity, a.column[place]) - load(velocity, i));
    Real* const to = &b[3 * static_cast<std::size_t>(i)];
    to[0] = rest.x, to[1] = rest.y, to[2] = rest.z;
  }
}

}  // namespace

Memory make_implicit_memory(const Elements<Real>& elements, const Array<Real>& inverse_mass) {
  Memory memory;
  memory.pattern = make_pattern(elements, inverse_mass);
  memory.matrix = make_block_rows<Real>(memory.pattern);
  memory.inverse = make_diagonal_block_rows<Real>(memory.pattern);
  const std::size_t n = elements.vertices;
  memory.diagonal.resize(9 * n), memory.b.resize(3 * n), memory.x.resize(3 * n);
  return memory;
}

void assemble(const Elements<Real>& elements, const Vectors<Real>& position, const Array<Real>& mass, Real time_step,
              Memory& memory) {
  const Scales<Real> scales = {time_step * time_step, time_step};
  const Pattern& pattern = memory.pattern;
  Matrix& a = memory.matrix;
  std::ranges::fill(a.value, Real(0));
  for (int k = 0; k < elements.links; ++k)
    add_share(pattern, pattern.of_link(k), stiffness_of_link(elements, position, scales, k), a);
  for (int t = 0; t < elements.membranes; ++t) {
    const Blocks<Real, membrane_pairs> blocks = stiffness_of_membrane(elements, position, scales, t);
    for (int p = 0; p < membrane_pairs; ++p) add_share(pattern, pattern.of_membrane(t) + p, blocks.of[p], a);
  }
  for (int h = 0; h < elements.hinges; ++h) {
    const Blocks<Real, hinge_pairs> blocks = stiffness_of_hinge(elements, position, scales, h);
    for (int p = 0; p < hinge_pairs; ++p) add_share(pattern, pattern.of_hinge(h) + p, blocks.of[p], a);
  }
  for (int row = 0; row < a.rows; ++row)
    if (a.begin[row] < a.begin[row + 1]) add_up_row(row, mass[row], memory);
}

linear::Solution implicit_solve(const Elements<Real>& elements, const Vectors<Real>& position, const Array<Real>& mass,
                                Real time_step, const Vectors<Real>& force, const linear::Stop& stop,
                                Vectors<Real>& velocity, Memory& memory) {
  assemble(elements, position, mass, time_step, memory);
  invert_diagonal(memory);
  set_right_side(memory.matrix, time_step, force, velocity, memory.b);

  const auto multiply = [&](std::span<const Real> p, std::span<Real> q) {
    linear::serial::multiply(memory.matrix, p, q);
    return linear::serial::dot(p, q);
  };
  const auto precondition = [&](std::span<const Real> r, std::span<Real> z) {
    linear::serial::multiply(memory.inverse, r, z);
    return linear::serial::dot(r, z);
  };
  const linear::Solution solution =
      linear::serial::conjugate_gradients({multiply, precondition, nullptr}, memory.b, memory.x, stop);

  for (int i = 0; i < elements.vertices; ++i) {
    const Real* const x = &memory.x[3 * static_cast<std::size_t>(i)];
    store(velocity, i, load(velocity, i) + Vector3<Real>{x[0], x[1], x[2]});
  }
  return solution;
}

}  // namespace lockstep::production_cloth::serial
