// Where the matrix of an implicit step has blocks, and which elements give to each.
//
// A block stands for two vertices of one element, or for one vertex. If for two, its shares are the blocks of elements
// with these corners (element_stiffness.h): of links, then of membranes, then of hinges, each in their order. Rows of
// held vertices have no blocks. Made once, by sequential code; positions do not change it.
#pragma once

#include <cstdint>

#include "common/linear/matrix.h"
#include "common/production_cloth/elastic.h"
#include "common/production_cloth/element_stiffness.h"

namespace lockstep::production_cloth {

struct Pattern {
  int vertices = 0;
  Array<std::int32_t> begin, column;  // of the block rows (common/linear/matrix.h)
  int first_membrane = 0, first_hinge = 0;
  int shares = 0;  // with those of the elements that fill up blocks of sixteen
  Array<std::int32_t>
      place;  // [2 share]: the block for the share's corners; [2 share + 1]: for them exchanged. -1: none
  // Block k's shares stand in share from first_share[k] to first_share[k + 1] - 1.
  Array<std::int32_t> first_share, share;

  int blocks() const { return static_cast<int>(column.size()); }
  int of_link(int k) const { return k; }
  int of_membrane(int t) const { return first_membrane + membrane_pairs * t; }  // of its first pair; the others follow
  int of_hinge(int h) const { return first_hinge + hinge_pairs * h; }
};

// inverse_mass: 0 of held vertices. Throws std::length_error where there are more than 2^31 / 2 shares.
template <class Real>
Pattern make_pattern(const Elements<Real>& elements, const Array<Real>& inverse_mass);

// The matrix with these blocks, all 0.
template <class Real>
linear::BlockRows<Real> make_block_rows(const Pattern& pattern) {
  return {pattern.vertices, pattern.vertices, pattern.begin, pattern.column,
          Array<Real>(9 * static_cast<std::size_t>(pattern.blocks()))};
}

// That with the diagonal blocks of its rows alone.
template <class Real>
linear::BlockRows<Real> make_diagonal_block_rows(const Pattern& pattern);

}  // namespace lockstep::production_cloth
