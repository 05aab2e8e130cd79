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
// Source: [ITJ07] on the broad phase. The contract stands in common/production_cloth/pairs.h.
#include "common/production_cloth/pairs.h"

#include "common/real.h"
#include "common/spatial/pairs.h"

namespace lockstep::production_cloth::serial {
namespace {

using namespace spatial;

// A tree, and nodes of elements that one descent has reached.
struct Reached {
  const Levels& levels;
  const Bounds<Real>& boxes;
  std::vector<int> nodes = {};

  // Adds the nodes from `from` on that overlap the box and are below a node of a level.
  void descend(const Box<Real>& box, int from, int level, int node) {
    for (int child = node * tree_width; child < (node + 1) * tree_width; ++child) {
      const bool before = child < from >> 4 * (level - 1);
      if (before || !overlap(box, boxes.box(levels.first[level] + child))) continue;
      if (level > 1)
        descend(box, from, level - 1, child);
      else
        nodes.push_back(child);
    }
  }
};

void add_pair(Array<ElementPair>& pairs, const ElementPair& pair) {
  const auto room = static_cast<double>(pairs.capacity());
  if (pairs.size() == pairs.capacity()) require_pairs_fit(2 * room, room);
  pairs.push_back(pair);
}

// Finds the pairs of elements of two trees. Elements of the same tree are found once: a < b. share(a)(b): whether
// they have a common vertex.
template <bool same, class Share>
void find(const Levels& levels_a, const Bounds<Real>& boxes_a, const Levels& levels_b, const Bounds<Real>& boxes_b,
          const Share& share, Array<ElementPair>& pairs) {
  Reached reached = {levels_b, boxes_b};
  pairs.clear();
  for (int node = 0; node < levels_a.nodes(); ++node) {
    reached.nodes.clear();
    reached.descend(boxes_a.box(levels_a.first[1] + node), same ? node : 0, levels_b.last(), 0);
    for (int a = node * tree_width; a < std::min((node + 1) * tree_width, levels_a.elements); ++a) {
      const Box<Real> box = boxes_a.box(a);
      const auto shares = share(a);
      for (const int other : reached.nodes) {
        if (!overlap(box, boxes_b.box(levels_b.first[1] + other))) continue;
        for (int b = other * tree_width; b < (other + 1) * tree_width; ++b)
          if ((!same || a < b) && overlap(box, boxes_b.box(b)) && !shares(b)) add_pair(pairs, {a, b});
      }
    }
  }
}

}  // namespace

void find_pairs(const Search& search, const SearchBoxes<Real>& boxes, ElementPairs& pairs) {
  const auto& end = search.ends;
  const auto& corner = search.corners;
  find<false>(
      search.vertices, boxes.vertices, search.triangles, boxes.triangles,
      [&](int a) {
        return [&corner, vertex = a](int b) {
          return is_corner(vertex, std::array{corner[0][b], corner[1][b], corner[2][b]});
        };
      },
      pairs.point_triangle);
  find<true>(
      search.edges, boxes.edges, search.edges, boxes.edges,
      [&](int a) {
        return [&end, ends = std::array{end[0][a], end[1][a]}](int b) {
          return share_end(ends, std::array{end[0][b], end[1][b]});
        };
      },
      pairs.edge_edge);
}

}  // namespace lockstep::production_cloth::serial
