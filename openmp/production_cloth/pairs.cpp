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
// Four nodes that are neighbours share the descent down to the blocks of sixteen nodes. From there on they take each
// stage in turn: how many a stage has found for a node is then known long before the next one's loops ask for it, so
// that a loop's end that the processor guesses wrong is soon found out.
//
// One instruction tests a box against sixteen: the children of a node; or the elements of the node that descends, whose
// boxes stay in registers. The result is a mask of partners for each element reached. Bit i of these masks says who
// the partners of the node's element i are, and lanes pack them, so that pairs are in order.
// Threads take groups as they come, and note where the pairs of each node stand in their lists, and how many each
// element has: that says what their first elements are. Then every node moves its pairs to where they belong.
//
// Source: [ITJ07] on the broad phase. The contract stands in common/production_cloth/pairs.h.
#include "common/production_cloth/pairs.h"

#include <algorithm>
#include <array>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

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

constexpr int group = 4;  // nodes; divides the children of a node

// A tree, and what the nodes of one group of the other have reached in it. Elements stand side by side, node by node,
// with the masks of whom they are no partners of; then those that are someone's partners, with masks of whose. Scratch
// of one thread, in cache lines of its own.
struct alignas(array_alignment) Reached {
  const Levels& levels;
  const Bounds<Real>& boxes;
  const Barred& barred;
  int blocks = 0;
  int first_node[group + 1] = {}, first[group + 1] = {}, count[group] = {};  // where a node's nodes and elements stand
  Array<std::int32_t> block = {}, above = {}, nodes = {}, elements = {}, masks = {}, overlaps = {};

  Reached(const Levels& levels, const Bounds<Real>& boxes, const Barred& barred)
      : levels(levels), boxes(boxes), barred(barred) {
    const int most_blocks = levels.nodes() / tree_width + 1;
    block.resize(padded(most_blocks)), above.resize(padded(most_blocks));
    make_room(tree_width);
  }

  // For `more` elements, and for sixteen that may be stored behind the last.
  [[gnu::noinline]] void make_room(int more) {
    for (Array<std::int32_t>* array : {&elements, &masks, &overlaps}) array->resize(padded(2 * more));
  }

  // Stores which of the sixteen children of a node overlap a box and are of nodes from `from` on. Says how many.
  LOCKSTEP_INLINE int children(int level, int parent, const Box<floatv>& box, int from, std::int32_t* to) const {
    const int child = parent * tree_width;
    const intv numbers = lane_index() + child;
    const maskv after = numbers >= from >> 4 * (level - 1);
    const maskv hit = after & overlap_by_signs(box, load_boxes(boxes, levels.first[level] + child));
    store(to, compress(hit, numbers));
    return lockstep::count(hit);
  }

  // The blocks of sixteen nodes that overlap the box of a group, of nodes from `from` on, level by level.
  LOCKSTEP_INLINE void descend(const Box<floatv>& box, int from) {
    block[0] = 0, blocks = 1;
    for (int level = levels.last(); level >= 2; --level) {
      block.swap(above);
      const int parents = std::exchange(blocks, 0);
      for (int k = 0; k < parents; ++k) blocks += children(level, above[k], box, from, &block[blocks]);
    }
  }

  // For the nodes of these blocks that each node of the group may reach.
  void make_room_for_nodes() { nodes.resize(std::max(nodes.size(), padded(2 * group * blocks * tree_width))); }

  // The nodes of these blocks that overlap the box of node g of the group.
  LOCKSTEP_INLINE void reach_nodes(int g, const Box<floatv>& box, int from) {
    int to = first_node[g];
    for (int k = 0; k < blocks; ++k) to += children(1, block[k], box, from, &nodes[to]);
    first_node[g + 1] = to;
  }

  // The elements of these nodes that overlap it. The node is that of the other tree.
  LOCKSTEP_INLINE void reach_elements(int g, int node, const Box<floatv>& box) {
    const int bars_nothing = barred.first[node + 1] - 1;
    int to = first[g];
    for (int k = first_node[g], row = barred.first[node]; k < first_node[g + 1]; ++k) {
      while (barred.node[row] < nodes[k]) ++row;
      add(box, nodes[k], &barred.masks[tree_width * (barred.node[row] == nodes[k] ? row : bars_nothing)], to);
    }
    count[g] = to - first[g];
    first[g + 1] = to + lanes;
  }

  LOCKSTEP_INLINE void add(const Box<floatv>& box, int node, const std::int32_t* masks_of_children, int& count) {
    const int child = node * tree_width;
    const maskv hit = overlap_by_signs(box, load_boxes(boxes, child));
    store(&elements[count], compress(hit, lane_index() + child));
    store(&masks[count], compress(hit, load(masks_of_children)));
    count += lockstep::count(hit);
  }

  // Keeps those that are partners of some of sixteen elements from the first on.
  LOCKSTEP_INLINE void keep_partners(int g, const Bounds<Real>& boxes_a, int first_a) {
    const Box<floatv> sixteen = load_boxes(boxes_a, first_a);
    std::int32_t *const element = &elements[first[g]], *const mask = &masks[first[g]], *const overlap = overlaps.data();
    const int n = count[g];
    for (int k = 0; k < n; ++k)
      overlap[k] = static_cast<std::int32_t>(bits(overlap_by_signs(sixteen, in_all_lanes(boxes.box(element[k])))));
    int kept = 0;
    for (int k = 0; k < n; k += lanes) {
      const intv partners = load(overlap + k) & (load(mask + k) ^ -1);
      const maskv hit = first_lanes(n - k) & (partners != 0);
      store(element + kept, compress(hit, load(element + k)));
      store(mask + kept, compress(hit, partners));
      kept += lockstep::count(hit);
    }
    count[g] = kept;
    store(mask + kept, intv(0));  // what fills up the last sixteen is nobody's partner
  }
};

// Where the pairs of a node stand: in which thread's list; and how many each of its elements has.
struct Found {
  int thread, begin;
  std::array<std::int32_t, tree_width> counts;
};

// Finds the pairs of elements of two trees, or of one.
void find(const Levels& levels_a, const Bounds<Real>& boxes_a, const Levels& levels_b, const Bounds<Real>& boxes_b,
          const Barred& barred, Array<ElementPair>& pairs) {
  const bool same = &levels_a == &levels_b;
  std::vector<Reached> of_threads(omp_get_max_threads(), Reached(levels_b, boxes_b, barred));
  const auto found = std::make_unique_for_overwrite<Found[]>(levels_a.nodes());
  // [node + 1]: how many pairs a node has; after the sum, [node]: where they begin in the result.
  std::vector<int> place(levels_a.nodes() + 1);

  const int groups = (levels_a.nodes() + group - 1) / group;
  const std::vector<PairList>& lists = collect(groups, 1, [&](int of_group, PairList& mine) {
    Reached& reached = of_threads[omp_get_thread_num()];
    const int first = of_group * group, n = std::min(group, levels_a.nodes() - first);
    const auto box_of = [&](int g) { return boxes_a.box(levels_a.first[1] + first + g); };
    Box<Real> around_all = box_of(0);
    for (int g = 1; g < n; ++g) around_all = around(around_all, box_of(g));
    reached.descend(in_all_lanes(around_all), same ? first : 0);
    mine.failure->guard([&] { reached.make_room_for_nodes(); });
    if (mine.failure->happened()) return;
    for (int g = 0; g < n; ++g) reached.reach_nodes(g, in_all_lanes(box_of(g)), same ? first + g : 0);
    const int most = reached.first_node[n] * tree_width + n * lanes;
    if (padded(most) > reached.elements.size()) mine.failure->guard([&] { reached.make_room(most); });
    if (mine.failure->happened()) return;
    for (int g = 0; g < n; ++g) reached.reach_elements(g, first + g, in_all_lanes(box_of(g)));
    for (int g = 0; g < n; ++g) reached.keep_partners(g, boxes_a, (first + g) * tree_width);

    std::int32_t* to = room_for(mine, tree_width * std::accumulate(reached.count, reached.count + n, 0));
    if (!to) return;
    for (int g = 0; g < n; ++g) {
      Found& of_node = found[first + g];
      of_node.thread = omp_get_thread_num(), of_node.begin = mine.count;
      const std::int32_t *const elements = &reached.elements[reached.first[g]], *const masks =
                                                                                    &reached.masks[reached.first[g]];
      const int count = reached.count[g];
      std::int32_t* const begin = to;
      for (int i = 0; i < tree_width; ++i) {
        std::int32_t* const first_of_i = to;
        for (int k = 0; k < count; k += lanes) {
          const maskv hit = (load(masks + k) & (1 << i)) != 0;
          store(to, compress(hit, load(elements + k)));
          to += lockstep::count(hit);
        }
        of_node.counts[i] = static_cast<int>(to - first_of_i);
      }
      place[first + g + 1] = static_cast<int>(to - begin);
      mine.count += place[first + g + 1];
    }
  });

  require_pairs_fit(count_pairs(lists), static_cast<double>(pairs.capacity()));
  std::partial_sum(place.begin(), place.end(), place.begin());
  pairs.resize(place.back());
  // The pairs of a node are one thread's, and go where no others do.
#pragma omp parallel for schedule(static)
  for (int node = 0; node < levels_a.nodes(); ++node) {
    const Found& f = found[node];
    const std::int32_t* b = lists[f.thread].b.data() + f.begin;
    ElementPair* to = pairs.data() + place[node];
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
