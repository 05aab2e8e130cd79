// The pairs of a cloth's elements whose boxes overlap: vertices meet the tree of triangles, edges meet their own tree.
//
// A node of sixteen elements descends the other tree as one: its neighbours on the cloth want the same nodes there.
// What its box overlaps are others, in the order of their numbers; then each of the sixteen elements is tested against
// those. So pairs come out in order, and each once: nothing is sorted, and no pair is found by way of two triangles,
// as it would be in a tree of triangles alone (which for a cloth on a ball holds 8.7 times as many pairs).
//
// Two edges are found from the lesser one: a node descends from its own place on.
//
// One instruction tests a box against sixteen: the children of a node, or elements that were reached, which are put
// side by side. Most of them are near the whole node, so that nothing is gained by asking first who is near whom.
// Threads take nodes as they come, and note where the pairs of each stand in their lists, and how many each element
// has: that says what their first elements are. Then every node moves its pairs to where they belong.
//
// Source: [ITJ07] on the broad phase. The contract stands in common/production_cloth/pairs.h.
#include "common/production_cloth/pairs.h"

#include <array>
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

// The boxes of active lanes, moved to the front.
LOCKSTEP_INLINE Box<floatv> compress(maskv mask, const Box<floatv>& box) {
  const auto moved = [=](const Vector3<floatv>& v) {
    return Vector3<floatv>{compress(mask, v.x), compress(mask, v.y), compress(mask, v.z)};
  };
  return {moved(box.low), moved(box.high)};
}

// A tree, and its elements that one descent has reached, with their boxes and the masks of whom they are no partners
// of. Scratch of one thread.
struct Reached {
  const Levels& levels;
  const Bounds<Real>& boxes;
  const Barred& barred;
  int count = 0, room = 0;
  Array<std::int32_t> nodes = {}, above = {}, elements = {}, masks = {};
  Bounds<Real> boxes_of_elements = {};

  Reached(const Levels& levels, const Bounds<Real>& boxes, const Barred& barred)
      : levels(levels), boxes(boxes), barred(barred) {
    nodes.resize(padded(levels.nodes())), above.resize(padded(levels.nodes()));
    make_room(tree_width);
  }

  // For `more` elements, and for sixteen that may be stored behind the last.
  [[gnu::noinline]] void make_room(int more) {
    const std::size_t with_padding = padded(2 * more) + lanes;
    elements.resize(with_padding), masks.resize(with_padding);
    boxes_of_elements.resize(static_cast<int>(with_padding));
    room = 2 * more;
  }

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
    if (reached * tree_width > room) failure.guard([&] { make_room(reached * tree_width); });
    if (failure.happened()) return;
    const int bars_nothing = barred.first[node + 1] - 1;
    for (int k = 0, row = barred.first[node]; k < reached; ++k) {
      while (barred.node[row] < nodes[k]) ++row;
      add(box, nodes[k], &barred.masks[tree_width * (barred.node[row] == nodes[k] ? row : bars_nothing)]);
    }
    // What fills up the last sixteen overlaps nothing.
    store_boxes(boxes_of_elements, count, in_all_lanes(empty_box<Real>));
  }

  LOCKSTEP_INLINE void add(const Box<floatv>& box, int node, const std::int32_t* masks_of_children) {
    const int child = node * tree_width;
    const Box<floatv> box_of_child = load_boxes(boxes, child);
    const maskv hit = overlap(box, box_of_child);
    store(&elements[count], compress(hit, lane_index() + child));
    store(&masks[count], compress(hit, load(masks_of_children)));
    store_boxes(boxes_of_elements, count, compress(hit, box_of_child));
    count += lockstep::count(hit);
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
    // The loop below stores to lists. The compiler cannot know that this leaves these pointers as they are.
    const Vector3<const float*> low = pointers(std::as_const(reached.boxes_of_elements.low)),
                                high = pointers(std::as_const(reached.boxes_of_elements.high));
    const std::int32_t *const elements = reached.elements.data(), *const masks = reached.masks.data();
    for (int a = node * tree_width; a < std::min((node + 1) * tree_width, levels_a.elements); ++a) {
      std::int32_t *const begin = room_for(mine, reached.count), *to = begin;
      if (!begin) return;
      const Box<floatv> box = in_all_lanes(boxes_a.box(a));
      const intv bit = 1 << a % tree_width;
      for (int k = 0; k < reached.count; k += lanes) {
        const maskv may = (load(masks + k) & bit) == 0;
        const maskv hit = may & overlap(box, Box<floatv>{load(low, k), load(high, k)});
        store(to, compress(hit, load(elements + k)));
        to += lockstep::count(hit);
      }
      of_node.counts[a % tree_width] = static_cast<int>(to - begin);
      mine.count += of_node.counts[a % tree_width];
    }
    of_node.count = mine.count - of_node.begin;
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
