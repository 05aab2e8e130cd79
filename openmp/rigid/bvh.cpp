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
// All pairs of a level make up a frontier, whose pairs threads take as they come; what they spawn is the frontier of the level below. A
// node is one vector: which of its children reach the other node is one test, and a child meets all of the other's at once.
//
// Source: [ITJ07] on the broad phase; Lauterbach et al., Fast BVH Construction on GPUs, Computer Graphics Forum 28 (2009), for the order.
// The contract stands in common/rigid/broad_phase.h.
#include <algorithm>
#include <bit>

#include "common/math.h"
#include "common/real.h"
#include "common/rigid/broad_phase.h"
#include "common/spatial/morton.h"
#include "common/simd.h"
#include "openmp/rigid/arranged.h"
#include "openmp/spatial/boxes.h"
#include "openmp/spatial/order_pairs.h"
#include "openmp/spatial/pair_list.h"
#include "openmp/spatial/radix_sort.h"

namespace lockstep::rigid::openmp {
namespace {

using namespace spatial;
using namespace spatial::openmp;

static_assert(tree_width == lanes);

// Twice where the centres are, least and greatest.
Box<Real> extent_of(const Bounds<Real>& bounds) {
  std::vector<Box<Real>> parts(omp_get_max_threads(), empty_box<Real>);
#pragma omp parallel
  {
    Box<floatv> extent = in_all_lanes(empty_box<Real>);
    // A thread keeps the extent of what it has seen; least and greatest are the same in any order.
#pragma omp for schedule(static) nowait
    for (int i = 0; i < bounds.count; i += lanes) {
      const Box<floatv> box = load_boxes(bounds, i);
      const maskv counts = first_lanes(bounds.count - i) & bounded(box);
      extent = select(counts, around(extent, {box.low + box.high, box.low + box.high}), extent);
    }
    parts[omp_get_thread_num()] = around_lanes(extent);
  }
  Box<Real> extent = empty_box<Real>;
  for (const Box<Real>& part : parts) extent = around(extent, part);
  return extent;
}

// Colliders by the codes of their centres, equal ones by number.
void sort_by_code(const Bounds<Real>& bounds, std::vector<std::int32_t>& order) {
  const Box<Real> extent = extent_of(bounds);
  const Real scale = morton_scale(extent);
  const auto code = [&](int i) {
    const Box<Real> box = bounds.box(i);
    return morton_code(box.low + box.high, extent.low, scale);
  };
  sort_by_key(bounds, morton_bits + 1, code, order);
}

// The box around the children of a node.
Box<Real> box_of_node(const Tree<Real>& tree, int level, int node) {
  return around_lanes(load_boxes(tree.boxes, tree.first[level - 1] + node * tree_width));
}

// Pairs of children of nodes a and b >= a of a level, which overlap. Calls spawn(i, mask, j): child i of a with children j of b.
template <class Spawn>
LOCKSTEP_INLINE void descend(const Tree<Real>& tree, int level, int a, int b, const Spawn& spawn) {
  const Bounds<Real>& boxes = tree.boxes;
  const int below = tree.first[level - 1];  // children are numbered within their level, whose boxes begin here
  const Box<floatv> box_b = in_all_lanes(boxes.box(tree.first[level] + b));
  const Box<floatv> box_j = load_boxes(boxes, below + b * tree_width);
  const maskv reach = overlap(load_boxes(boxes, below + a * tree_width), box_b);
  for (std::uint32_t set = bits(reach); set != 0; set &= set - 1) {
    const int child = std::countr_zero(set), i = a * tree_width + child;
    // A node meets itself; a collider does not.
    const maskv met = a < b ? first_lanes(lanes) : ~first_lanes(level > 1 ? child : child + 1);
    const maskv hit = met & overlap(in_all_lanes(boxes.box(below + i)), box_j);
    if (any(hit)) spawn(i, hit, b * tree_width);
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
#pragma omp parallel
  {
    int n = static_cast<int>(tree.order.size());
    for (int level = 0; level < tree.levels(); ++level) {
      const int first = tree.first[level], slots = tree.first[level + 1] - first;
      // Every box of a level is one thread's, made from the level below; the loop's barrier ends it before the next level is begun.
#pragma omp for schedule(static)
      for (int i = 0; i < slots; ++i)
        boxes.set(first + i, i >= n       ? empty_box<Real>
                             : level == 0 ? zeros_positive(bounds.box(tree.order[i]))
                                          : box_of_node(tree, level, i));
      n = (n + tree_width - 1) / tree_width;
    }
  }
}

void tree_pairs(const Tree<Real>& tree, const Bounds<Real>& bounds, std::span<const std::int32_t> group, Pairs& pairs) {
  const Arranged& sorted = arrange(bounds, group, tree.order);
  const int root = tree.levels() - 1;
  // Pairs of nodes are found, of colliders in the end. The tree is only read, what is found goes to a thread's own list.
  const std::vector<PairList>* found = &collect(root > 0, 1, [](int, PairList& mine) { add(mine, first_lanes(1), 0, 0); });
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
  order_pairs(bounds.count, *found, pairs);
}

}  // namespace lockstep::rigid::openmp
