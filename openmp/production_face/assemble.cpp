// The stiffness matrix, block by block.
//
// The algorithm and its serial form stand in serial/production_face/assemble.cpp. Tetrahedra that share a node would
// write the same blocks, so the work falls into two passes. First, sixteen tetrahedra at a time store their shares.
// Then each row sums the shares of its blocks in the order of tetrahedra, which is the order of the serial loop.
//
// A share is stored for the block above the diagonal, and the block below it reads the same: K is symmetric to the bit.
//
// The contract stands in common/production_face/assemble.h.
#include "common/production_face/assemble.h"

#include <algorithm>
#include <utility>

#include "common/real.h"
#include "common/simd.h"

namespace lockstep::production_face::openmp {
namespace {

constexpr int numbers = 9 * pairs;  // that a tetrahedron stores

// Shares are prefetched so many before their turn, about one row: the processor does not foresee their order.
constexpr int ahead = 72;

// The entries that a transposition exchanges.
constexpr std::pair<int, int> off_diagonal[] = {{1, 3}, {2, 6}, {5, 7}};

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
      floatv(&of)[9] = k.block[block_of[a][c]];
      for (const auto& [i, j] : off_diagonal) {
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

// The blocks of a row; entry e of block i goes to to[16 (9 i + e)]. Columns ascend. Lanes 0 to 8 are the entries, those
// of the transpose left of the diagonal.
void add_up_row(const Pattern& pattern, const Array<Real>& shares, int row, Real* to) {
  const auto store_block = [&](int place, const Real* block, bool transposed) {
    Real* const first = to + 9 * lanes * (place - pattern.begin[row]);
    for (int r = 0; r < 3; ++r)
      for (int s = 0; s < 3; ++s) first[lanes * (3 * r + s)] = block[transposed ? 3 * s + r : 3 * r + s];
  };
  const auto share = [&](int s) { return &shares[9 * static_cast<std::size_t>(pattern.share[s])]; };
  const int last = static_cast<int>(pattern.share.size()) - 1;
  floatv left = 0.f, right = 0.f;
  int own = 0;
  for (int place = pattern.begin[row]; place < pattern.begin[row + 1]; ++place) {
    floatv block = 0.f;
    for (int s = pattern.first_share[place]; s < pattern.first_share[place + 1]; ++s) {
      __builtin_prefetch(share(std::min(s + ahead, last)));
      block += load(share(s));
    }
    const bool is_left = pattern.column[place] < row;
    if (pattern.column[place] == row) own = place;
    (is_left ? left : right) += block;
    Real entry[lanes];
    store(entry, block);
    store_block(place, entry, is_left);
  }
  Real of_left[lanes], of_right[lanes], diagonal[9];
  store(of_left, left), store(of_right, right);
  for (const auto& [i, j] : off_diagonal) std::swap(of_left[i], of_left[j]);
  set_diagonal(of_left, of_right, diagonal);
  store_block(own, diagonal, false);
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
    for (int lane = 0; lane < lanes; ++lane)
      if (const int row = k.row[slice * lanes + lane]; row >= 0 && pattern.begin[row] < pattern.begin[row + 1])
        add_up_row(pattern, shares, row, &k.value[9 * lanes * static_cast<std::size_t>(k.first_slot[slice]) + lane]);
}

}  // namespace lockstep::production_face::openmp
