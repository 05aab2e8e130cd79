// The stiffness matrix, block by block.
//
// The algorithm and its serial form stand in serial/production_face/assemble.cpp. Tetrahedra that share a node would
// write the same blocks, so the work falls into two passes. First, sixteen tetrahedra at a time store their shares. Then
// each row sums the shares of its blocks in the order of tetrahedra, which is the order of the serial loop.
//
// A share is stored for the block above the diagonal, and the block below it reads the same: K is symmetric to the bit.
//
// The contract stands in common/production_face/assemble.h.
#include "common/production_face/assemble.h"

#include <algorithm>

#include "common/real.h"
#include "common/simd.h"

namespace lockstep::production_face::openmp {
namespace {

constexpr int numbers = 9 * upper_blocks;  // that a tetrahedron stores

ElementStiffness<floatv> stiffness_of(const Body<Real>& body, const Strained<Real>& strained, int block) {
  const auto field = [&](const Blocked<Real>& array, int k) { return load(array.vector(block, k)); };
  const auto e = strained_element<floatv>(body, strained, field);
  ElementStiffness<floatv> k;
  set_flesh_stiffness(e, k);
  for (int slot = body.first_fibre[block]; slot < body.first_fibre[block + 1]; ++slot) {
    const auto in_slot = [&](const Blocked<Real>& array, int k) { return load(array.vector(slot, k)); };
    add_fibre_stiffness(e, strained_fibre<floatv>(body, strained, in_slot), k);
  }
  set_first_corner(k);
  return k;
}

// Transposes the blocks whose row's node has the greater number, so that all stand above the diagonal of the matrix.
void turn_upward(const Body<Real>& body, int block, ElementStiffness<floatv>& k) {
  for (int a = 0; a < 4; ++a)
    for (int c = a + 1; c < 4; ++c) {
      const maskv below = load(body.corner.vector(block, a)) > load(body.corner.vector(block, c));
      floatv(&of)[9] = k.block[upper_block(a, c)];
      for (const auto& [i, j] : {std::pair{1, 3}, {2, 6}, {5, 7}}) {
        const floatv above = select(below, of[j], of[i]);
        of[j] = select(below, of[i], of[j]), of[i] = above;
      }
    }
}

// A tetrahedron's numbers stand side by side.
void store_shares(const ElementStiffness<floatv>& k, float* to) {
  for (int first = 0; first < numbers; first += lanes) {
    const int count = std::min(numbers - first, lanes);
    floatv row[lanes];
    for (int i = 0; i < lanes; ++i) row[i] = i < count ? k.block[(first + i) / 9][(first + i) % 9] : floatv(0.f);
    transpose(row);
    for (int l = 0; l < lanes; ++l) store(to + numbers * l + first, row[l], first_lanes(count));
  }
}

}  // namespace

void assemble(const Body<Real>& body, const Strained<Real>& strained, const Pattern& pattern, Array<Real>& shares,
              linear::SlicedBlockRows& k) {
  // A block of tetrahedra writes its own shares.
#pragma omp parallel for schedule(static)
  for (int block = 0; block < body.blocks(); ++block) {
    ElementStiffness<floatv> e = stiffness_of(body, strained, block);
    turn_upward(body, block, e);
    store_shares(e, &shares[static_cast<std::size_t>(block) * lanes * numbers]);
  }
  // A slice writes its own rows, and reads shares that nobody writes any more.
#pragma omp parallel for schedule(static)
  for (int slice = 0; slice < k.slices(); ++slice)
    for (int lane = 0; lane < lanes; ++lane) {
      const int row = k.row[slice * lanes + lane];
      for (int i = 0; i < k.length[slice * lanes + lane]; ++i) {
        const int place = pattern.begin[row] + i;
        floatv sum = 0.f;
        for (int s = pattern.first_share[place]; s < pattern.first_share[place + 1]; ++s)
          sum += load(&shares[9 * static_cast<std::size_t>(pattern.share[s])]);
        float above[lanes];
        store(above, sum);
        const bool below = pattern.column[place] < row;
        Real* const to = &k.value[9 * lanes * static_cast<std::size_t>(k.first_slot[slice] + i) + lane];
        for (int r = 0; r < 3; ++r)
          for (int c = 0; c < 3; ++c) to[lanes * (3 * r + c)] = above[below ? 3 * c + r : 3 * r + c];
      }
    }
}

}  // namespace lockstep::production_face::openmp
