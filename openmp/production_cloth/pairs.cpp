// The pairs of a cloth's elements whose boxes overlap: vertices meet the tree of triangles, edges meet their own tree.
//
// A node of sixteen elements descends the other tree as one: its neighbours on the cloth want the same nodes there.
// What it reaches are nodes of sixteen others, in the order of their numbers; then each of the sixteen elements looks
// into those of them that its own box overlaps. So pairs come out in order, and each once: nothing is sorted, and no
// pair is found by way of two triangles, as it would be in a tree of triangles alone (which for a cloth on a ball holds
// 8.7 times as many pairs).
//
// Two edges are found from the lesser one: a node descends from its own place on.
//
// One instruction tests a box against sixteen: the children of a node, or nodes that were reached, whose boxes are put
// side by side. Threads take nodes as they come, and note where the pairs of each stand in their lists; then every node
// moves its pairs to where they belong.
//
// Source: [ITJ07] on the broad phase. The contract stands in common/production_cloth/pairs.h.
#include "common/production_cloth/pairs.h"

#include <bit>

#include "common/real.h"
#include "common/simd.h"
#include "common/spatial/pairs.h"
#include "openmp/spatial/boxes.h"
#include "openmp/spatial/pair_list.h"

namespace lockstep::production_cloth::openmp {
namespace {

using namespace spatial;
using namespace spatial::openmp;

// The boxes of active lanes, moved to the front.
LOCKSTEP_INLINE Box<floatv> compress(maskv mask, const Box<floatv>& box) {
  const auto moved = [=](const Vector3<floatv>& v) {
    return Vector3<floatv>{compress(mask, v.x), compress(mask, v.y), compress(mask, v.z)};
  };
  return {moved(box.low), moved(box.high)};
}

// A tree, and nodes of elements that one descent has reached, with their boxes. Scratch of one thread.
struct Reached {
  const Levels& levels;
  const Bounds<Real>& boxes;
  int count = 0;
  Array<std::int32_t> nodes = {}, above = {};
  Bounds<Real> boxes_of_nodes = {};

  Reached(const Levels& levels, const Bounds<Real>& boxes) : levels(levels), boxes(boxes) {
    nodes.resize(padded(levels.nodes())), above.resize(padded(levels.nodes()));
    boxes_of_nodes.resize(levels.nodes());
  }

  // The nodes from `from` on that overlap the box, level by level.
  LOCKSTEP_INLINE void descend(const Box<floatv>& box, int from) {
    nodes[0] = 0, count = 1;
    for (int level = levels.last(); level >= 1; --level) {
      nodes.swap(above);
      const int n = std::exchange(count, 0);
      for (int k = 0; k < n; ++k) {
        const int child = above[k] * tree_width;
        const intv children = lane_index() + child;
        const maskv after = children >= from >> 4 * (level - 1);
        const Box<floatv> boxes_of_children = load_boxes(boxes, levels.first[level] + child);
        const maskv hit = after & overlap(box, boxes_of_children);
        store(&nodes[count], compress(hit, children));
        if (level == 1) store_boxes(boxes_of_nodes, count, compress(hit, boxes_of_children));
        count += lockstep::count(hit);
      }
    }
  }
};

// Where the pairs of a node stand: in which thread's list, and in the result.
struct Found {
  int thread = 0, begin = 0, count = 0, place = 0;
};

// Finds the pairs of elements of two trees. Elements of the same tree are found once: a < b. share(a)(b): whether
// they have a common vertex.
template <bool same, class Share>
void find(const Levels& levels_a, const Bounds<Real>& boxes_a, const Levels& levels_b, const Bounds<Real>& boxes_b,
          const Share& share, Array<ElementPair>& pairs) {
  std::vector<Reached> of_threads(omp_get_max_threads(), Reached(levels_b, boxes_b));
  std::vector<Found> found(levels_a.nodes());

  const std::vector<PairList>& lists = collect(levels_a.nodes(), 4, [&](int node, PairList& mine) {
    Reached& reached = of_threads[omp_get_thread_num()];
    const int begin = mine.count;
    reached.descend(in_all_lanes(boxes_a.box(levels_a.first[1] + node)), same ? node : 0);
    for (int a = node * tree_width; a < std::min((node + 1) * tree_width, levels_a.elements); ++a) {
      const Box<floatv> box = in_all_lanes(boxes_a.box(a));
      const auto shares = share(a);
      for (int k = 0; k < reached.count; k += lanes) {
        const maskv near = first_lanes(reached.count - k) & overlap(box, load_boxes(reached.boxes_of_nodes, k));
        for (std::uint32_t set = bits(near); set != 0; set &= set - 1) {
          const int other = reached.nodes[k + std::countr_zero(set)] * tree_width;
          const intv b = lane_index() + other;
          const maskv hit = overlap(box, load_boxes(boxes_b, other));
          if (none(hit)) continue;
          const maskv once = same ? hit & (b > a) : hit;
          add(mine, once & !shares(other), a, b);
        }
      }
    }
    found[node] = {omp_get_thread_num(), begin, mine.count - begin, 0};
  });

  require_pairs_fit(count_pairs(lists), static_cast<double>(pairs.capacity()));
  int count = 0;
  for (Found& f : found) f.place = std::exchange(count, count + f.count);
  pairs.resize(count);
  // The pairs of a node are one thread's, and go where no others do.
#pragma omp parallel for schedule(static)
  for (const Found& f : found) {
    const std::int32_t *a = lists[f.thread].a.data() + f.begin, *b = lists[f.thread].b.data() + f.begin;
    ElementPair* const to = pairs.data() + f.place;
    for (int k = 0; k < f.count; ++k) to[k] = {a[k], b[k]};
  }
}

}  // namespace

void find_pairs(const Search& search, const SearchBoxes<Real>& boxes, ElementPairs& pairs) {
  const auto& end = search.ends;
  const auto& corner = search.corners;
  find<false>(
      search.vertices, boxes.vertices, search.triangles, boxes.triangles,
      [&](int a) {
        return [&corner, vertex = intv(a)](int b) {
          return is_corner(vertex, std::array{load(&corner[0][b]), load(&corner[1][b]), load(&corner[2][b])});
        };
      },
      pairs.point_triangle);
  find<true>(
      search.edges, boxes.edges, search.edges, boxes.edges,
      [&](int a) {
        return [&end, ends = std::array<intv, 2>{end[0][a], end[1][a]}](int b) {
          return share_end(ends, std::array{load(&end[0][b]), load(&end[1][b])});
        };
      },
      pairs.edge_edge);
}

}  // namespace lockstep::production_cloth::openmp
