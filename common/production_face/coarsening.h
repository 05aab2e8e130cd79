// Coarse levels of a face for its preconditioner (multigrid.h): nodes in aggregates that move as rigid bodies, these in
// larger ones, and so on, until a level has at most `most_at_last` aggregates or does not get smaller.
//
// An aggregate has six numbers, a translation t and a rotation w. Its member i, a node or an aggregate of the level
// before, moves by P_i = [1 R_i; 0 1] of them (a node has the first row alone):
//
//   u_i = t + w x d_i,   w_i = w,   d_i the member's centre from the aggregate's, over the level's length
//
// so that w has the size of t. A centre is the mean of the nodes. Nodes on a line do not determine a rotation about it.
// Where the nodes of an aggregate, and those of each of its members, are about on a line, all its d_i are 0, and so are
// the rows of its rotation in the coarse matrix.
//
// The coarse matrix P^T K P couples aggregates I and J by the sum of P_i^T K_ij P_j, i in I and j in J. It has its
// blocks of 6x6 as four of 3x3, of block rows 2 I and 2 I + 1, so that linear's products take it. K is symmetric, so
// couplings are computed for I <= J alone.
//
// Made once from a body, by sequential code; poses do not change it.
//
// Source: Vanek, Mandel and Brezina, Algebraic multigrid by smoothed aggregation for second and fourth order elliptic
//         problems, Computing 56 (1996): aggregates and rigid bodies; the smoothing of P is left out.
#pragma once

#include <cstdint>
#include <vector>

#include "common/array.h"
#include "common/linear/matrix.h"
#include "common/production_face/body.h"
#include "common/production_face/pattern.h"

namespace lockstep::production_face {

// Any two elements that begin aggregates are more than so many edges apart.
inline constexpr int reach_of_nodes = 3, reach_of_aggregates = 1;
inline constexpr int most_at_last = 100;  // aggregates of the last level, whose matrix is factored

template <class Real>
struct CoarseLevel {
  int parts = 1;                 // of a member: 1 of a node, 2 (translation and rotation) of an aggregate
  Array<std::int32_t> of;        // [member]: its aggregate; -1 of a held node
  Array<Real> arm;               // [3 member + c]: d
  Array<std::int32_t> first{0};  // [aggregate]: its first member in `member`; and their number, behind the last
  Array<std::int32_t> member;    // ascending in each aggregate

  Array<std::int32_t> begin{0}, column;  // of the coarse matrix, as linear::BlockRows has them

  // A coupling (I, J), I <= J, is a sum of shares, of members i and j in ascending order. Couplings are ordered by
  // their number of shares, within windows, so that neighbours have about as many.
  struct Coupling {
    std::int32_t place[2][2];     // of blocks (2 I + p, 2 J + q) of the coarse matrix
    std::int32_t mirrored[2][2];  // of blocks (2 J + q, 2 I + p)
  };
  std::vector<Coupling> coupling;
  Array<std::int32_t> diagonal;        // [aggregate]: its coupling with itself
  Array<std::int32_t> first_share{0};  // [coupling]; and the number of shares, behind the last
  Array<std::int32_t> i, j;            // [share]: its two members
  Array<std::int32_t> share;           // [(share * parts + p) * parts + q]: the block of K for part p of i and q of j

  int count() const { return static_cast<int>(first.size()) - 1; }
  int couplings() const { return static_cast<int>(coupling.size()); }
  std::size_t members() const { return of.size(); }
};

template <class Real>
struct Coarsening {
  std::vector<CoarseLevel<Real>> level;  // none if no node is free
};

// `pattern` is the body's.
template <class Real>
Coarsening<Real> make_coarsening(const Body<Real>& body, const Pattern& pattern);

// The coarse matrix, all 0.
template <class Real>
linear::BlockRows<Real> make_block_rows(const CoarseLevel<Real>& level) {
  return {2 * level.count(), 2 * level.count(), level.begin, level.column, Array<Real>(9 * level.column.size())};
}

// The 6x6 blocks on its diagonal, alone.
template <class Real>
linear::BlockRows<Real> make_diagonal_rows(const CoarseLevel<Real>& level) {
  linear::BlockRows<Real> rows = {2 * level.count(), 2 * level.count(), {0}, {}, {}};
  for (int row = 0; row < rows.rows; ++row) {
    rows.column.push_back(row / 2 * 2), rows.column.push_back(row / 2 * 2 + 1);
    rows.begin.push_back(static_cast<std::int32_t>(rows.column.size()));
  }
  rows.value.resize(9 * rows.column.size());
  return rows;
}

}  // namespace lockstep::production_face
