// A tree of boxes over colliders, sixteen to a node, without a pointer.
//
// Colliders that have bounds are put in an order in which neighbours are near each other. Of that order, level 0 of the tree is their
// boxes; box i of each further level is around boxes 16 i .. 16 i + 15 of the level below; the last level has one box, the root. Each level
// is padded with empty boxes to whole nodes, so that a node is always sixteen boxes side by side.
//
//     level 2                          0
//     level 1      0         1        2       ...        15
//     level 0   0 .. 15  16 .. 31  32 .. 47         240 .. 255    <- order[0] .. order[255]
#pragma once

#include <vector>

#include "common/spatial/bounds.h"

namespace lockstep::spatial {

inline constexpr int tree_width = 16;

template <class Real>
struct Tree {
  std::vector<std::int32_t> order;  // colliders
  std::vector<int> first;           // [level]: where its boxes begin; one more, where the last level ends
  Bounds<Real> boxes;               // of all levels

  int levels() const { return static_cast<int>(first.size()) - 1; }
};

// Where the levels begin over n boxes; no level over none.
inline std::vector<int> level_starts(int n) {
  std::vector<int> first = {0};
  while (n > 0) {
    const int nodes = (n + tree_width - 1) / tree_width;
    first.push_back(first.back() + nodes * tree_width);
    n = n == 1 ? 0 : nodes;
  }
  return first;
}

// Without negative zeros, so that least and greatest do not depend on who is asked first.
template <class T>
inline Box<T> zeros_positive(const Box<T>& box) {
  const Vector3<T> zero = {T(0), T(0), T(0)};
  return {box.low + zero, box.high + zero};
}

}  // namespace lockstep::spatial
