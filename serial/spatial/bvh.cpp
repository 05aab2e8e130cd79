// A bounding volume hierarchy: a tree of boxes.
//
// To build it, elements are sorted by the Morton codes of their boxes' centres. Every sixteen in a row become a node,
// and every sixteen nodes become another: one sort, and no choices (common/spatial/tree.h). Where boxes are alike, such
// a tree is little worse than one whose every cut is chosen. One box far from all others makes the cells of the code
// coarse: the boxes stay right, the tree gets worse. To fit it, the order is kept and only the boxes are made anew,
// bottom up.
//
// Source: [ITJ07] on the broad phase; Lauterbach et al., Fast BVH Construction on GPUs, Computer Graphics Forum 28
// (2009), for the order. The contract stands in common/spatial/tree.h.
#include <algorithm>
#include <utility>

#include "common/math.h"
#include "common/real.h"
#include "common/spatial/morton.h"
#include "common/spatial/tree.h"

namespace lockstep::spatial::serial {
namespace {

// The smallest box around twice the centres.
Box<Real> extent_of(const Bounds<Real>& bounds) {
  Box<Real> extent = empty_box<Real>;
  for (int i = 0; i < bounds.count; ++i)
    if (bounds.bounded(i)) {
      const Box<Real> box = bounds.box(i);
      extent = around(extent, {box.low + box.high, box.low + box.high});
    }
  return extent;
}

// Sorts the bounded elements by the Morton codes of their centres, equal ones by number.
void sort_by_code(const Bounds<Real>& bounds, std::vector<std::int32_t>& order) {
  const Box<Real> extent = extent_of(bounds);
  const Real scale = morton_scale(extent);
  std::vector<std::pair<std::int32_t, std::int32_t>> keys;
  for (int i = 0; i < bounds.count; ++i)
    if (bounds.bounded(i)) {
      const Box<Real> box = bounds.box(i);
      keys.push_back({morton_code(box.low + box.high, extent.low, scale), i});
    }
  std::sort(keys.begin(), keys.end());
  order.clear();
  for (const auto& [key, i] : keys) order.push_back(i);
}

// The box around the children of a node.
Box<Real> box_of_node(const Tree<Real>& tree, int level, int node) {
  Box<Real> box = empty_box<Real>;
  for (int c = 0; c < tree_width; ++c) box = around(box, tree.boxes.box(tree.first[level - 1] + node * tree_width + c));
  return box;
}

}  // namespace

void bvh_build(const Bounds<Real>& bounds, Tree<Real>& tree) {
  sort_by_code(bounds, tree.order);
  tree.first = level_starts(static_cast<int>(tree.order.size()));
  tree.boxes.resize(tree.first.back());
  bvh_refit(bounds, tree);
}

void bvh_refit(const Bounds<Real>& bounds, Tree<Real>& tree) {
  Bounds<Real>& boxes = tree.boxes;
  int n = static_cast<int>(tree.order.size());
  for (int level = 0; level < tree.levels(); ++level) {
    const int first = tree.first[level], slots = tree.first[level + 1] - first;
    for (int i = 0; i < slots; ++i)
      boxes.set(first + i, i >= n       ? empty_box<Real>
                           : level == 0 ? zeros_positive(bounds.box(tree.order[i]))
                                        : box_of_node(tree, level, i));
    n = (n + tree_width - 1) / tree_width;
  }
}

}  // namespace lockstep::spatial::serial
