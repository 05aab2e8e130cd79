// The pairs of a cloth's elements whose boxes overlap: vertices meet the tree of triangles, edges meet their own tree.
//
// A node of sixteen elements descends the other tree as one: its neighbours on the cloth want the same nodes there.
// What its box overlaps are others, in the order of their numbers; then each of the sixteen elements is tested against
// those. So pairs come out in order, and each once: nothing is sorted, and no pair is found by way of two triangles,
// as it would be in a tree of triangles alone (which for a cloth on a ball holds 8.7 times as many pairs).
//
// Two edges are found from the lesser one: a node descends from its own place on.
//
// Source: [ITJ07] on the broad phase. The contract stands in common/production_cloth/pairs.h.
#include "common/production_cloth/pairs.h"

#include "common/real.h"
#include "common/spatial/pairs.h"

namespace lockstep::production_cloth::serial {
namespace {

using namespace spatial;

// A tree, and its elements that one descent has reached, with their boxes and vertices.
template <std::size_t n>
struct Reached {
  const Levels& levels;
  const Bounds<Real>& boxes;
  const std::array<Array<std::int32_t>, n>& corners;
  int count = 0, room = 0;
  Array<std::int32_t> elements = {};
  Bounds<Real> boxes_of_elements = {};
  std::array<Array<std::int32_t>, n> corners_of_elements = {};

  void make_room(int more) {
    elements.resize(more), boxes_of_elements.resize(more);
    for (Array<std::int32_t>& corner : corners_of_elements) corner.resize(more);
    room = more;
  }

  // Adds the elements that overlap the box, of nodes from `from` on, below a node of a level.
  void descend(const Box<Real>& box, int from, int level, int node) {
    if (level == 0) return add(box, node);
    for (int child = node * tree_width; child < (node + 1) * tree_width; ++child) {
      const bool before = child < from >> 4 * (level - 1);
      if (!before && overlap(box, boxes.box(levels.first[level] + child))) descend(box, from, level - 1, child);
    }
  }

  // Each element is stored, and the next one over it if it does not overlap: no branch to be foreseen.
  void add(const Box<Real>& box, int node) {
    if (count + tree_width > room) make_room(2 * (count + tree_width));
    int to = count;
    for (int child = node * tree_width; child < (node + 1) * tree_width; ++child) {
      const Box<Real> box_of_child = boxes.box(child);
      elements[to] = child, boxes_of_elements.set(to, box_of_child);
      for (std::size_t c = 0; c < n; ++c) corners_of_elements[c][to] = corners[c][child];
      to += overlap(box, box_of_child);
    }
    count = to;
  }
};

void add_pair(Array<ElementPair>& pairs, const ElementPair& pair) {
  const auto room = static_cast<double>(pairs.capacity());
  if (pairs.size() == pairs.capacity()) require_pairs_fit(2 * room, room);
  pairs.push_back(pair);
}

// Finds the pairs of elements of two trees. Elements of the same tree are found once: a < b. share(a)(corner): whether
// they have a common vertex.
template <bool same, std::size_t n, class Share>
void find(const Levels& levels_a, const Bounds<Real>& boxes_a, const Levels& levels_b, const Bounds<Real>& boxes_b,
          const std::array<Array<std::int32_t>, n>& corners_b, const Share& share, Array<ElementPair>& pairs) {
  Reached<n> reached = {levels_b, boxes_b, corners_b};
  Array<std::int32_t> hit, hits;  // [k]: whether element k of those reached overlaps; [k]: which do
  pairs.clear();
  for (int node = 0; node < levels_a.nodes(); ++node) {
    reached.count = 0;
    reached.descend(boxes_a.box(levels_a.first[1] + node), same ? node : 0, levels_b.last(), 0);
    const int count = reached.count;
    hit.resize(reached.room), hits.resize(reached.room);
    for (int a = node * tree_width; a < std::min((node + 1) * tree_width, levels_a.elements); ++a) {
      const Box<Real> box = boxes_a.box(a);
      const auto shares = share(a);
      // The compiler makes vectors of the first loop, and the second has no branch that depends on the boxes.
      for (int k = 0; k < count; ++k) hit[k] = overlap(box, reached.boxes_of_elements.box(k));
      int found = 0;
      for (int k = 0; k < count; ++k) hits[found] = k, found += hit[k];
      for (int k = 0; k < found; ++k) {
        const int b = reached.elements[hits[k]];
        std::array<int, n> corner;
        for (std::size_t c = 0; c < n; ++c) corner[c] = reached.corners_of_elements[c][hits[k]];
        if ((!same || a < b) && !shares(corner)) add_pair(pairs, {a, b});
      }
    }
  }
}

}  // namespace

void find_pairs(const Search& search, const SearchBoxes<Real>& boxes, ElementPairs& pairs) {
  const auto& end = search.ends;
  find<false>(
      search.vertices, boxes.vertices, search.triangles, boxes.triangles, search.corners,
      [&](int a) { return [vertex = a](const std::array<int, 3>& corner) { return is_corner(vertex, corner); }; },
      pairs.point_triangle);
  find<true>(
      search.edges, boxes.edges, search.edges, boxes.edges, search.ends,
      [&](int a) {
        return [ends = std::array<int, 2>{end[0][a], end[1][a]}](const std::array<int, 2>& other) {
          return share_end(ends, other);
        };
      },
      pairs.edge_edge);
}

}  // namespace lockstep::production_cloth::serial
