// The pairs of a cloth's elements whose boxes overlap: vertices meet the tree of triangles, edges meet their own tree.
//
// A node of sixteen elements descends the other tree as one: its neighbours on the cloth want the same nodes there.
// What its box overlaps are others, in the order of their numbers; then each of those is tested against the sixteen
// elements. So no pair is found by way of two triangles, as it would be in a tree of triangles alone (which for a cloth
// on a ball holds 8.7 times as many pairs), and nothing is sorted.
//
// Two edges are found from the lesser one: a node descends from its own place on. Who has a common vertex is known in
// advance (common/production_cloth/search.h).
//
// One instruction tests a box against sixteen: the children of a node; or the elements of the node that descends, whose
// boxes stay in registers. The result is a mask of partners for each element reached. Bit i of these masks says who
// the partners of the node's element i are, and lanes pack them, so that pairs are in order.
// Threads take nodes as they come, and note where the pairs of each stand in their lists, and how many each element
// has: that says what their first elements are. Then every node moves its pairs to where they belong.
//
// Source: [ITJ07] on the broad phase. The contract stands in common/production_cloth/pairs.h.
#include "common/production_cloth/pairs.h"

#include <array>
#include <bit>
#include <utility>

#include "common/real.h"
#include "common/simd.h"
#include "common/spatial/pairs.h"
#include "openmp/spatial/boxes.h"
#include "openmp/spatial/pair_list.h"
#include "openmp/vector_lanes.h"

namespace lockstep::production_cloth::openmp {
namespace {

using namespace spatial;
using namespace spatial::openmp;
using lockstep::openmp::Failure;

// A tree, and those of its elements that one descent has reached, with the masks of whom they are no partners of;
// then those that are someone's partners, with masks of whose. Scratch of one thread.
struct Reached {
  const Levels& levels;
  const Bounds<Real>& boxes;
  const Barred& barred;
  int count = 0;
  Array<std::int32_t> nodes = {}, above = {}, elements = {}, masks = {};

  Reached(const Levels& levels, const Bounds<Real>& boxes, const Barred& barred)
      : levels(levels), boxes(boxes), barred(barred) {
    nodes.resize(padded(levels.nodes())), above.resize(padded(levels.nodes()));
    make_room(tree_width);
  }

  // For `more` elements, and for sixteen that may be stored behind the last.
  [[gnu::noinline]] void make_room(int more) { elements.resize(padded(2 * more)), masks.resize(padded(2 * more)); }

  // The elements that overlap the box of a node of the other tree, of nodes from `from` on, level by level.
  LOCKSTEP_INLINE void descend(int node, const Box<floatv>& box, int from, Failure& failure) {
    nodes[0] = 0, count = 1;
    for (int level = levels.last(); level >= 1; --level) {
      nodes.swap(above);
      const int parents = std::exchange(count, 0);
      for (int k = 0; k < parents; ++k) {
        const int child = above[k] * tree_width;
        const intv children = lane_index() + child;
        const maskv after = children >= from >> 4 * (level - 1);
        const maskv hit = after & overlap(box, load_boxes(boxes, levels.first[level] + child));
        store(&nodes[count], compress(hit, children));
        count += lockstep::count(hit);
      }
    }
    const int reached = std::exchange(count, 0);
    if (padded(reached * tree_width) > elements.size()) failure.guard([&] { make_room(reached * tree_width); });
    if (failure.happened()) return;
    const int bars_nothing = barred.first[node + 1] - 1;
    for (int k = 0, row = barred.first[node]; k < reached; ++k) {
      while (barred.node[row] < nodes[k]) ++row;
      add(box, nodes[k], &barred.masks[tree_width * (barred.node[row] == nodes[k] ? row : bars_nothing)]);
    }
  }

  LOCKSTEP_INLINE void add(const Box<floatv>& box, int node, const std::int32_t* masks_of_children) {
    const int child = node * tree_width;
    const maskv hit = overlap(box, load_boxes(boxes, child));
    store(&elements[count], compress(hit, lane_index() + child));
    store(&masks[count], compress(hit, load(masks_of_children)));
    count += lockstep::count(hit);
  }

  // Keeps those that are partners of some of sixteen elements from the first on.
  LOCKSTEP_INLINE void keep_partners(const Bounds<Real>& boxes_a, int first) {
    const Box<floatv> sixteen = load_boxes(boxes_a, first);
    std::int32_t *const element = elements.data(), *const mask = masks.data();
    int kept = 0;
    for (int k = 0; k < count; ++k) {
      const int b = element[k];
      const Box<Real> box = boxes.box(b);
      const int partners = static_cast<int>(bits(overlap(sixteen, box))) & ~mask[k];
      element[kept] = b, mask[kept] = partners;
      kept += partners != 0;
    }
    count = kept;
    store(&mask[kept], intv(0));  // what fills up the last sixteen is nobody's partner
  }
};

// Where the pairs of a node stand: in which thread's list, and in the result; and how many each of its elements has.
struct Found {
  int thread = 0, begin = 0, count = 0, place = 0;
  std::array<std::int32_t, tree_width> counts = {};
};

// Finds the pairs of elements of two trees, or of one.
void find(const Levels& levels_a, const Bounds<Real>& boxes_a, const Levels& levels_b, const Bounds<Real>& boxes_b,
          const Barred& barred, Array<ElementPair>& pairs) {
  const bool same = &levels_a == &levels_b;
  std::vector<Reached> of_threads(omp_get_max_threads(), Reached(levels_b, boxes_b, barred));
  std::vector<Found> found(levels_a.nodes());

  const std::vector<PairList>& lists = collect(levels_a.nodes(), 4, [&](int node, PairList& mine) {
    Reached& reached = of_threads[omp_get_thread_num()];
    Found& of_node = found[node];
    of_node.thread = omp_get_thread_num(), of_node.begin = mine.count;
    reached.descend(node, in_all_lanes(boxes_a.box(levels_a.first[1] + node)), same ? node : 0, *mine.failure);
    reached.keep_partners(boxes_a, node * tree_width);
    std::int32_t *const begin = room_for(mine, tree_width * reached.count), *to = begin;
    if (!begin) return;
    const std::int32_t *const elements = reached.elements.data(), *const masks = reached.masks.data();
    const int count = reached.count;
    for (int i = 0; i < tree_width; ++i) {
      std::int32_t* const first = to;
      for (int k = 0; k < count; k += lanes) {
        const maskv hit = (load(masks + k) & (1 << i)) != 0;
        store(to, compress(hit, load(elements + k)));
        to += lockstep::count(hit);
      }
      of_node.counts[i] = static_cast<int>(to - first);
    }
    of_node.count = static_cast<int>(to - begin);
    mine.count += of_node.count;
  });

  require_pairs_fit(count_pairs(lists), static_cast<double>(pairs.capacity()));
  int count = 0;
  for (Found& f : found) f.place = std::exchange(count, count + f.count);
  pairs.resize(count);
  // The pairs of a node are one thread's, and go where no others do.
#pragma omp parallel for schedule(static)
  for (int node = 0; node < levels_a.nodes(); ++node) {
    const Found& f = found[node];
    const std::int32_t* b = lists[f.thread].b.data() + f.begin;
    ElementPair* to = pairs.data() + f.place;
    for (int l = 0; l < tree_width; ++l)
      for (int k = 0; k < f.counts[l]; ++k) *to++ = {node * tree_width + l, *b++};
  }
}

}  // namespace

void find_pairs(const Search& search, const SearchBoxes<Real>& boxes, ElementPairs& pairs) {
  find(search.vertices, boxes.vertices, search.triangles, boxes.triangles, search.point_triangle, pairs.point_triangle);
  find(search.edges, boxes.edges, search.edges, boxes.edges, search.edge_edge, pairs.edge_edge);
}

}  // namespace lockstep::production_cloth::openmp
