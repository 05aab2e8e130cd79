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

// A tree, and its elements that one descent has reached, with their boxes and vertices. Scratch of one thread.
template <std::size_t n>
struct Reached {
  const Levels& levels;
  const Bounds<Real>& boxes;
  const std::array<Array<std::int32_t>, n>& corners;
  int count = 0, room = 0;
  Array<std::int32_t> nodes = {}, above = {}, elements = {};
  Bounds<Real> boxes_of_elements = {};
  std::array<Array<std::int32_t>, n> corners_of_elements = {};

  Reached(const Levels& levels, const Bounds<Real>& boxes, const std::array<Array<std::int32_t>, n>& corners)
      : levels(levels), boxes(boxes), corners(corners) {
    nodes.resize(padded(levels.nodes())), above.resize(padded(levels.nodes()));
    make_room(tree_width);
  }

  // For `more` elements, and for sixteen that may be stored behind the last.
  [[gnu::noinline]] void make_room(int more) {
    const std::size_t with_padding = padded(2 * more) + lanes;
    elements.resize(with_padding), boxes_of_elements.resize(static_cast<int>(with_padding));
    for (Array<std::int32_t>& corner : corners_of_elements) corner.resize(with_padding);
    room = 2 * more;
  }

  // The elements that overlap the box, of nodes from `from` on, level by level.
  LOCKSTEP_INLINE void descend(const Box<floatv>& box, int from, Failure& failure) {
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
    for (int k = 0; k < reached; ++k) add(box, nodes[k]);
    // What fills up the last sixteen overlaps nothing.
    store_boxes(boxes_of_elements, count, in_all_lanes(empty_box<Real>));
  }

  LOCKSTEP_INLINE void add(const Box<floatv>& box, int node) {
    const int child = node * tree_width;
    const Box<floatv> box_of_child = load_boxes(boxes, child);
    const maskv hit = overlap(box, box_of_child);
    store(&elements[count], compress(hit, lane_index() + child));
    store_boxes(boxes_of_elements, count, compress(hit, box_of_child));
    for (std::size_t c = 0; c < n; ++c) store(&corners_of_elements[c][count], compress(hit, load(&corners[c][child])));
    count += lockstep::count(hit);
  }
};

// Where the pairs of a node stand: in which thread's list, and in the result; and how many each of its elements has.
struct Found {
  int thread = 0, begin = 0, count = 0, place = 0;
  std::array<std::int32_t, tree_width> counts = {};
};

// Finds the pairs of elements of two trees. Elements of the same tree are found once: a < b. share(a)(corner): whether
// they have a common vertex.
template <bool same, std::size_t n, class Share>
void find(const Levels& levels_a, const Bounds<Real>& boxes_a, const Levels& levels_b, const Bounds<Real>& boxes_b,
          const std::array<Array<std::int32_t>, n>& corners_b, const Share& share, Array<ElementPair>& pairs) {
  std::vector<Reached<n>> of_threads(omp_get_max_threads(), Reached<n>(levels_b, boxes_b, corners_b));
  std::vector<Found> found(levels_a.nodes());

  const std::vector<PairList>& lists = collect(levels_a.nodes(), 4, [&](int node, PairList& mine) {
    Reached<n>& reached = of_threads[omp_get_thread_num()];
    Found& of_node = found[node];
    of_node.thread = omp_get_thread_num(), of_node.begin = mine.count;
    reached.descend(in_all_lanes(boxes_a.box(levels_a.first[1] + node)), same ? node : 0, *mine.failure);
    // The loop below stores to lists. The compiler cannot know that this leaves these pointers as they are.
    const Vector3<const float*> low = pointers(std::as_const(reached.boxes_of_elements.low)),
                                high = pointers(std::as_const(reached.boxes_of_elements.high));
    const std::int32_t* const elements = reached.elements.data();
    std::array<const std::int32_t*, n> corners;
    for (std::size_t c = 0; c < n; ++c) corners[c] = reached.corners_of_elements[c].data();
    for (int a = node * tree_width; a < std::min((node + 1) * tree_width, levels_a.elements); ++a) {
      std::int32_t *const begin = room_for(mine, reached.count), *to = begin;
      if (!begin) return;
      const Box<floatv> box = in_all_lanes(boxes_a.box(a));
      const auto shares = share(a);
      for (int k = 0; k < reached.count; k += lanes) {
        std::array<intv, n> corner;
        for (std::size_t c = 0; c < n; ++c) corner[c] = load(corners[c] + k);
        const intv b = load(elements + k);
        const maskv hit = overlap(box, Box<floatv>{load(low, k), load(high, k)});
        const maskv once = (same ? hit & (b > a) : hit) & !shares(corner);
        store(to, compress(once, b));
        to += lockstep::count(once);
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
  const auto& end = search.ends;
  find<false>(
      search.vertices, boxes.vertices, search.triangles, boxes.triangles, search.corners,
      [&](int a) {
        return [vertex = intv(a)](const std::array<intv, 3>& corner) { return is_corner(vertex, corner); };
      },
      pairs.point_triangle);
  find<true>(
      search.edges, boxes.edges, search.edges, boxes.edges, search.ends,
      [&](int a) {
        return [ends = std::array<intv, 2>{end[0][a], end[1][a]}](const std::array<intv, 2>& other) {
          return share_end(ends, other);
        };
      },
      pairs.edge_edge);
}

}  // namespace lockstep::production_cloth::openmp
