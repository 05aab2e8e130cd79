// The pairs of boxes in a bounding volume hierarchy that overlap.
//
// The tree is descended against itself, by pairs of nodes. The children of two overlapping nodes that overlap each
// other are pairs of the level below: "computation that spawns more computation", [ITJ07]. A child that does not
// overlap the whole other node is dropped before it meets that node's children. The descent starts with the root paired
// with itself. openmp/spatial/bvh.cpp makes the tree.
//
// All node pairs of a level form a frontier. Threads take its pairs as they come; the pairs that they spawn form the
// frontier of the level below. A node's sixteen boxes are one vector: one test says which of them reach the other node,
// and each of those meets all sixteen of the other node at once.
//
// Source: [ITJ07] on the broad phase. The contract stands in common/rigid/broad_phase.h.
#include <bit>

#include "common/math.h"
#include "common/real.h"
#include "common/rigid/broad_phase.h"
#include "common/rigid/limits.h"
#include "common/simd.h"
#include "openmp/rigid/arranged.h"
#include "openmp/spatial/boxes.h"
#include "openmp/spatial/order_pairs.h"
#include "openmp/spatial/pair_list.h"

namespace lockstep::rigid::openmp {
namespace {

using namespace spatial;
using namespace spatial::openmp;

// Finds the pairs of overlapping children of nodes a and b >= a of a level. Calls spawn(i, mask, j): child i of a with
// children j of b.
template <class Spawn>
LOCKSTEP_INLINE void descend(const Tree<Real>& tree, int level, int a, int b, const Spawn& spawn) {
  const Bounds<Real>& boxes = tree.boxes;
  const int below = tree.first[level - 1];  // where the boxes of the children's level begin
  const Box<floatv> box_b = in_all_lanes(boxes.box(tree.first[level] + b));
  const Box<floatv> box_j = load_boxes(boxes, below + b * tree_width);
  const maskv reach = overlap(load_boxes(boxes, below + a * tree_width), box_b);
  for (std::uint32_t set = bits(reach); set != 0; set &= set - 1) {
    const int child = std::countr_zero(set), i = a * tree_width + child;
    // A node is paired with itself, a collider is not.
    const maskv met = a < b ? first_lanes(lanes) : !first_lanes(level > 1 ? child : child + 1);
    const maskv hit = met & overlap(in_all_lanes(boxes.box(below + i)), box_j);
    if (any(hit)) spawn(i, hit, b * tree_width);
  }
}

}  // namespace

void bvh_pairs(const Tree<Real>& tree, const Bounds<Real>& bounds, std::span<const std::int32_t> group, Pairs& pairs) {
  const Arranged& sorted = arrange(bounds, group, tree.order);
  const int root = tree.levels() - 1;
  // Pairs of nodes are found, and of colliders at the last level. The tree is only read; the pairs that a thread finds
  // go to its own list.
  const std::vector<PairList>* found =
      &collect(root > 0, 1, [](int, PairList& mine) { add(mine, first_lanes(1), 0, 0); });
  for (int level = root; level > 0; --level) {
    const PairList& frontier = joined(*found);
    found = &collect(frontier.count, 16, [&](int k, PairList& mine) {
      const Owners owners(sorted);
      descend(tree, level, frontier.a[k], frontier.b[k], [&](int i, maskv hit, int j) {
        if (level > 1) {
          add(mine, hit, i, lane_index() + j);
        } else {
          add_hits(owners, i, j, hit, mine);
        }
      });
    });
  }
  require_contacts_fit(count_pairs(*found), pairs.capacity());
  order_pairs(bounds.count, *found, pairs);
}

}  // namespace lockstep::rigid::openmp
