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

#include <array>
#include <utility>

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
  Array<std::int32_t> nodes = {}, above = {}, elements = {};
  Bounds<Real> boxes_of_elements = {};
  std::array<Array<std::int32_t>, n> corners_of_elements = {};

  Reached(const Levels& levels, const Bounds<Real>& boxes, const std::array<Array<std::int32_t>, n>& corners)
      : levels(levels), boxes(boxes), corners(corners) {
    nodes.resize(padded(levels.nodes())), above.resize(padded(levels.nodes()));
    make_room(tree_width);
  }

  // For `more` elements.
  void make_room(int more) {
    elements.resize(2 * more), boxes_of_elements.resize(2 * more);
    for (Array<std::int32_t>& corner : corners_of_elements) corner.resize(2 * more);
    room = 2 * more;
  }

  // The elements that overlap the box, of nodes from `from` on, level by level. What is reached is stored, and the next
  // stored over it if it does not overlap: no branch depends on the boxes.
  void descend(const Box<Real>& box, int from) {
    nodes[0] = 0, count = 1;
    for (int level = levels.last(); level >= 1; --level) {
      nodes.swap(above);
      const int parents = std::exchange(count, 0);
      for (int k = 0; k < parents; ++k)
        for (int child = above[k] * tree_width; child < (above[k] + 1) * tree_width; ++child) {
          const bool after = child >= from >> 4 * (level - 1);
          const bool hit = after & overlap(box, boxes.box(levels.first[level] + child));
          nodes[count] = child;
          count += hit;
        }
    }
    const int reached = std::exchange(count, 0);
    if (reached * tree_width > room) make_room(reached * tree_width);
    for (int k = 0; k < reached; ++k) add(box, nodes[k]);
  }

  void add(const Box<Real>& box, int node) {
    int count = this->count;  // which stays in a register
    for (int child = node * tree_width; child < (node + 1) * tree_width; ++child) {
      const Box<Real> box_of_child = boxes.box(child);
      const bool hit = overlap(box, box_of_child);
      elements[count] = child, boxes_of_elements.set(count, box_of_child);
      for (std::size_t c = 0; c < n; ++c) corners_of_elements[c][count] = corners[c][child];
      count += hit;
    }
    this->count = count;
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
  Reached<n> reached(levels_b, boxes_b, corners_b);
  Array<std::int32_t> hit, hits;  // [k]: whether element k of those reached overlaps; [k]: which do
  pairs.clear();
  for (int node = 0; node < levels_a.nodes(); ++node) {
    reached.descend(boxes_a.box(levels_a.first[1] + node), same ? node : 0);
    // The loops below store. The compiler cannot know that this leaves these as they are.
    const int count = reached.count;
    const std::int32_t* const elements = reached.elements.data();
    std::array<const std::int32_t*, n> corners;
    for (std::size_t c = 0; c < n; ++c) corners[c] = reached.corners_of_elements[c].data();
    hit.resize(reached.room), hits.resize(reached.room);
    for (int a = node * tree_width; a < std::min((node + 1) * tree_width, levels_a.elements); ++a) {
      const Box<Real> box = boxes_a.box(a);
      const auto shares = share(a);
      // The compiler makes vectors of the first loop, and the second has no branch that depends on the boxes.
      for (int k = 0; k < count; ++k) hit[k] = overlap(box, reached.boxes_of_elements.box(k));
      int found = 0;
      for (int k = 0; k < count; ++k) hits[found] = k, found += hit[k];
      for (int k = 0; k < found; ++k) {
        std::array<int, n> corner;
        for (std::size_t c = 0; c < n; ++c) corner[c] = corners[c][hits[k]];
        const int b = elements[hits[k]];
        if ((!same || b > a) && !shares(corner)) add_pair(pairs, {a, b});
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
