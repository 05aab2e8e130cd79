// Contract: a bounding volume hierarchy over boxes, built or fitted.
//
// The tree has sixteen boxes to a node and no pointers. The bounded elements are put in an order in which neighbours
// are near each other. Level 0 holds their boxes in that order. Box i of each further level is the smallest around
// boxes 16 i .. 16 i + 15 of the level below. The last level has one box, the root. Each level is padded with empty
// boxes to whole nodes, so that a node is always sixteen boxes side by side.
//
//     level 2                          0
//     level 1      0         1        2       ...        15
//     level 0   0 .. 15  16 .. 31  32 .. 47         240 .. 255    <- order[0] .. order[255]
//
//   bvh_build  makes the tree from nothing: in the order of the Morton codes of the boxes' centres, equal ones by
//              number
//   bvh_refit  keeps the order of a tree that bvh_build made over the same elements, and makes its boxes anew
//
// In: bounds. Out: tree, resized; it is owned by the caller. Zeros in its boxes are positive. Source: [ITJ07] on the
// broad phase; Lauterbach et al., Fast BVH Construction on GPUs, Computer Graphics Forum 28 (2009).
#pragma once

#include <cstdint>
#include <vector>

#include "common/spatial/bounds.h"

namespace lockstep::spatial {

inline constexpr int tree_width = 16;

template <class Real>
struct Tree {
  std::vector<std::int32_t> order;  // numbers of the bounded elements
  std::vector<int> first;           // [level]: where its boxes begin; one more entry, where the last level ends
  Bounds<Real> boxes;               // of all levels, the lowest first

  int levels() const { return static_cast<int>(first.size()) - 1; }
};

// Where the levels begin over n boxes; there is no level over none.
inline std::vector<int> level_starts(int n) {
  std::vector<int> first = {0};
  while (n > 0) {
    const int nodes = (n + tree_width - 1) / tree_width;
    first.push_back(first.back() + nodes * tree_width);
    n = n == 1 ? 0 : nodes;
  }
  return first;
}

// Makes negative zeros positive. The least of -0 and 0 would depend on which is compared first.
template <class T>
inline Box<T> zeros_positive(const Box<T>& box) {
  const Vector3<T> zero = {T(0), T(0), T(0)};
  return {box.low + zero, box.high + zero};
}

template <class Real>
using BuildTree = void(const Bounds<Real>& bounds, Tree<Real>& tree);

namespace serial {
BuildTree<float> bvh_build, bvh_refit;
BuildTree<double> bvh_build, bvh_refit;
}  // namespace serial

namespace openmp {
BuildTree<float> bvh_build, bvh_refit;
}  // namespace openmp

}  // namespace lockstep::spatial
