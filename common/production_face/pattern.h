// Where a body's stiffness matrix has blocks, and which tetrahedra give to each.
//
// A block stands for two nodes of one tetrahedron, or for one node. If for two, its shares are the blocks (a, c) of
// tetrahedra whose corners a and c are these nodes (element_stiffness.h). Rows of held nodes have no blocks: their
// forces are the bones'. Made once from a body, by sequential code; poses do not change it.
#pragma once

#include <cstdint>

#include "common/array.h"
#include "common/linear/matrix.h"
#include "common/production_face/body.h"

namespace lockstep::production_face {

struct Pattern {
  int nodes = 0;
  Array<std::int32_t> begin, column;  // of the block rows (common/linear/matrix.h)
  Array<std::int32_t> place;          // [16 tetrahedron + 4 a + c]: the block for corners a and c; -1 if a is held
  // Block k's shares stand from first_share[k] to first_share[k + 1] - 1, in the order of tetrahedra:
  // pairs * tetrahedron + block_of[a][c].
  Array<std::int32_t> first_share, share;

  int blocks() const { return static_cast<int>(column.size()); }
};

// Throws std::length_error where a body has more than 2^31 / 16 tetrahedra.
template <class Real>
Pattern make_pattern(const Body<Real>& body);

// The matrix with these blocks, all 0.
template <class Real>
linear::BlockRows<Real> make_block_rows(const Pattern& pattern) {
  return {pattern.nodes, pattern.nodes, pattern.begin, pattern.column,
          Array<Real>(9 * static_cast<std::size_t>(pattern.blocks()))};
}

}  // namespace lockstep::production_face
