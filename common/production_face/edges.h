// A stiffness matrix by nodes and edges: as it is symmetric, each block beside the diagonal is stored once.
//
// This is how PARSEC's facesim stores it. An edge is two nodes with a block between them.
#pragma once

#include "common/linear/matrix.h"

namespace lockstep::production_face {

template <class Real>
struct Edges {
  int nodes = 0;
  Array<Real> at_node;              // 6 a node: xx, xy, xz, yy, yz, zz of its block of the diagonal
  Array<std::int32_t> first, last;  // [edge]: its nodes, first < last
  Array<Real> between;              // 9 an edge: the block in the row of first and the column of last, row by row
  Array<std::int32_t> held;         // the nodes whose rows are empty, ascending
};

// The matrix must be symmetric to the bit, except that rows may be empty (pattern.h).
template <class Real>
Edges<Real> make_edges(const linear::BlockRows<Real>& k);

}  // namespace lockstep::production_face
