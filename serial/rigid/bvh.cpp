// A bounding volume hierarchy: a tree of boxes, and the pairs of its nodes that overlap, down to the colliders.
//
// Built from nothing, colliders are sorted by the Morton codes of their centres, and every sixteen in a row become a node, of which every
// sixteen become another: one sort, and no choices (common/spatial/tree.h). What that loses to a tree whose every cut is chosen is little
// where boxes are alike. One body far from all others makes the cells of the code coarse; the pairs stay right, the tree gets worse.
// Fitted, the order is kept and only the boxes are made anew, bottom up.
//
// Pairs are found by descending the tree against itself. Of two nodes of a level that overlap, the children that overlap are pairs of the
// level below: "computation that spawns more computation", [ITJ07]. A child that does not reach the other node at all is dropped
// before it meets that node's children. A node is first paired with itself, the root.
//
// Source: [ITJ07] on the broad phase; Lauterbach et al., Fast BVH Construction on GPUs, Computer Graphics Forum 28 (2009), for the order.
// The contract stands in common/rigid/broad_phase.h.
#include <algorithm>
#include <utility>

#include "common/math.h"
#include "common/real.h"
#include "common/rigid/broad_phase.h"
#include "common/spatial/morton.h"
#include "common/spatial/order_pairs.h"

namespace lockstep::rigid::serial {
namespace {

using namespace spatial;

// Twice where the centres are, least and greatest.
Box<Real> extent_of(const Bounds<Real>& bounds) {
  Box<Real> extent = empty_box<Real>;
  for (int i = 0; i < bounds.count; ++i)
    if (bounds.bounded(i)) {
      const Box<Real> box = bounds.box(i);
      extent = around(extent, {box.low + box.high, box.low + box.high});
    }
  return extent;
}

// Colliders by the codes of their centres, equal ones by number.
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

// Pairs of children of nodes a and b >= a of a level, which overlap.
void descend(const Tree<Real>& tree, std::span<const std::int32_t> group, int level, int a, int b, Pairs& pairs) {
  const Bounds<Real>& boxes = tree.boxes;
  const int below = tree.first[level - 1];  // children are numbered within their level, whose boxes begin here
  const Box<Real> box_b = boxes.box(tree.first[level] + b);
  for (int i = a * tree_width; i < (a + 1) * tree_width; ++i) {
    const Box<Real> box_i = boxes.box(below + i);
    if (!overlap(box_i, box_b)) continue;
    // A node meets itself; a collider does not.
    for (int j = a < b ? b * tree_width : level > 1 ? i : i + 1; j < (b + 1) * tree_width; ++j) {
      if (!overlap(box_i, boxes.box(below + j))) continue;
      if (level > 1) {
        descend(tree, group, level - 1, i, j, pairs);
      } else if (group[tree.order[i]] != group[tree.order[j]]) {
        pairs.push_back(make_pair(tree.order[i], tree.order[j]));
      }
    }
  }
}

}  // namespace

void build_tree(const Bounds<Real>& bounds, Tree<Real>& tree) {
  sort_by_code(bounds, tree.order);
  tree.first = level_starts(static_cast<int>(tree.order.size()));
  tree.boxes.resize(tree.first.back());
  refit_tree(bounds, tree);
}

void refit_tree(const Bounds<Real>& bounds, Tree<Real>& tree) {
  Bounds<Real>& boxes = tree.boxes;
  int n = static_cast<int>(tree.order.size());
  for (int level = 0; level < tree.levels(); ++level) {
    const int first = tree.first[level], slots = tree.first[level + 1] - first;
    for (int i = 0; i < slots; ++i)
      boxes.set(first + i, i >= n ? empty_box<Real> : level == 0 ? zeros_positive(bounds.box(tree.order[i])) : box_of_node(tree, level, i));
    n = (n + tree_width - 1) / tree_width;
  }
}

void tree_pairs(const Tree<Real>& tree, const Bounds<Real>& bounds, std::span<const std::int32_t> group, Pairs& pairs) {
  pairs.clear();
  if (tree.levels() > 1) descend(tree, group, tree.levels() - 1, 0, 0, pairs);
  order_pairs(bounds.count, pairs);
}

}  // namespace lockstep::rigid::serial
