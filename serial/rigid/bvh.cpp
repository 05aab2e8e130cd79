// The pairs of boxes in a bounding volume hierarchy that overlap.
//
// The tree is descended against itself, by pairs of nodes. The children of two overlapping nodes that overlap each
// other are pairs of the level below: "computation that spawns more computation", [ITJ07]. A child that does not
// overlap the whole other node is dropped before it meets that node's children. The descent starts with the root paired
// with itself. serial/spatial/bvh.cpp makes the tree.
//
// Source: [ITJ07] on the broad phase. The contract stands in common/rigid/broad_phase.h.
#include "common/math.h"
#include "common/real.h"
#include "common/rigid/broad_phase.h"
#include "common/rigid/limits.h"
#include "common/spatial/order_pairs.h"

namespace lockstep::rigid::serial {
namespace {

using namespace spatial;

// Finds the pairs of overlapping children of nodes a and b >= a of a level.
void descend(const Tree<Real>& tree, std::span<const std::int32_t> group, int level, int a, int b, Pairs& pairs) {
  const Bounds<Real>& boxes = tree.boxes;
  const int below = tree.first[level - 1];  // where the boxes of the children's level begin
  const Box<Real> box_b = boxes.box(tree.first[level] + b);
  for (int i = a * tree_width; i < (a + 1) * tree_width; ++i) {
    const Box<Real> box_i = boxes.box(below + i);
    if (!overlap(box_i, box_b)) continue;
    // A node is paired with itself, a collider is not.
    for (int j = a < b ? b * tree_width : level > 1 ? i : i + 1; j < (b + 1) * tree_width; ++j) {
      if (!overlap(box_i, boxes.box(below + j))) continue;
      if (level > 1) {
        descend(tree, group, level - 1, i, j, pairs);
      } else if (group[tree.order[i]] != group[tree.order[j]]) {
        add_pair(pairs, make_pair(tree.order[i], tree.order[j]));
      }
    }
  }
}

}  // namespace

void bvh_pairs(const Tree<Real>& tree, const Bounds<Real>& bounds, std::span<const std::int32_t> group, Pairs& pairs) {
  const std::size_t room = pairs.capacity();
  pairs.clear();
  if (tree.levels() > 1) descend(tree, group, tree.levels() - 1, 0, 0, pairs);
  require_contacts_fit(pairs.size(), room);
  order_pairs(bounds.count, pairs);
}

}  // namespace lockstep::rigid::serial
