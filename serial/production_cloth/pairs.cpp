// The pairs of a cloth's elements whose boxes overlap: vertices meet the tree of triangles, edges meet their own tree.
//
// A node of sixteen elements descends the other tree as one: its neighbours on the cloth want the same nodes there. What
// it reaches are nodes of sixteen others, in the order of their numbers, of which only what overlaps the node is kept;
// then each of the sixteen elements looks into those of them that its own box overlaps. So pairs come out in order, and each once: nothing is sorted, and no pair is
// found by way of two triangles, as it would be in a tree of triangles alone (which for a cloth on a ball holds 8.7
// times as many pairs).
//
// Two edges are found from the lesser one: a node descends from its own place on.
//
// Source: [ITJ07] on the broad phase. The contract stands in common/production_cloth/pairs.h.
#include "common/production_cloth/pairs.h"

#include "common/math.h"
#include "common/real.h"
#include "common/spatial/pairs.h"

namespace lockstep::production_cloth::serial {
namespace {

using namespace spatial;

// Whether closed boxes overlap. No difference of two numbers is 0 but that of equal ones, so it is exact; one comparison
// takes less time than six whose outcome nobody can guess.
bool meet(const Box<Real>& a, const Box<Real>& b) {
  const Real x = max(a.low.x - b.high.x, b.low.x - a.high.x), y = max(a.low.y - b.high.y, b.low.y - a.high.y);
  return max(max(x, y), max(a.low.z - b.high.z, b.low.z - a.high.z)) <= 0;
}

// An element, or elements begin .. end - 1 of those in reach, and the box around.
struct Element {
  Box<Real> box;
  int number;
};
struct Node {
  Box<Real> box;
  std::size_t begin, end;
};

// So few elements in reach are tested without their nodes: that takes less than to guess which nodes a box overlaps.
constexpr int few = 4 * tree_width;

// A tree, and what one descent has reached: nodes, and those of their elements that are in reach themselves. Their
// boxes are put one behind the other, as sixteen elements go through them.
struct Reached {
  const Levels& levels;
  const Bounds<Real>& boxes;
  std::vector<Node> nodes = {};
  std::vector<Element> elements = {};

  // Adds what overlaps the box and is below a node of a level, of nodes from `from` on.
  void descend(const Box<Real>& box, int from, int level, int node) {
    for (int child = node * tree_width; child < (node + 1) * tree_width; ++child) {
      if (child < from >> 4 * (level - 1)) continue;
      const Box<Real> of_child = boxes.box(levels.first[level] + child);
      if (!meet(box, of_child)) continue;
      if (level > 1)
        descend(box, from, level - 1, child);
      else
        add(box, child, of_child);
    }
  }

  void add(const Box<Real>& box, int node, const Box<Real>& of_node) {
    const std::size_t begin = elements.size();
    for (int e = node * tree_width; e < (node + 1) * tree_width; ++e)
      if (const Box<Real> of_element = boxes.box(e); meet(box, of_element)) elements.push_back({of_element, e});
    if (elements.size() > begin) nodes.push_back({of_node, begin, elements.size()});
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
    reached.nodes.clear(), reached.elements.clear();
    reached.descend(boxes_a.box(levels_a.first[1] + node), same ? node : 0, levels_b.last(), 0);
    if (reached.elements.size() <= few) reached.nodes = {{whole_space<Real>, 0, reached.elements.size()}};
    for (int a = node * tree_width; a < std::min((node + 1) * tree_width, levels_a.elements); ++a) {
      const Box<Real> box = boxes_a.box(a);
      const auto shares = share(a);
      for (const Node& other : reached.nodes) {
        if (!meet(box, other.box)) continue;
        // What a box overlaps is hard to guess, too, so that it decides on no branch.
        int hits = 0, pairs_of_a = 0, hit[few];
        for (std::size_t k = other.begin; k < other.end; ++k) {
          const Element& b = reached.elements[k];
          hit[hits] = b.number;
          hits += meet(box, b.box) & (!same || a < b.number);
        }
        for (int k = 0; k < hits; ++k) {
          const bool is_pair = !shares(hit[k]);
          hit[pairs_of_a] = hit[k];
          pairs_of_a += is_pair;
        }
        for (int k = 0; k < pairs_of_a; ++k) add_pair(pairs, {a, hit[k]});
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
