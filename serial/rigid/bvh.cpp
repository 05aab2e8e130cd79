// The pairs of boxes in a bounding volume hierarchy that overlap.
//
// The tree is descended against itself, by pairs of nodes. Of two nodes of a level that overlap, the children that overlap are pairs of the
// level below: "computation that spawns more computation", [ITJ07]. A child that does not reach the other node at all is dropped
// before it meets that node's children. The root is first paired with itself. How the tree is made: serial/spatial/bvh.cpp.
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
