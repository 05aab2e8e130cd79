// The pairs of a cloth's elements whose boxes overlap: vertices meet the tree of triangles, edges meet their own tree.
//
// A node of sixteen elements descends the other tree as one: its neighbours on the cloth want the same nodes there.
// What its box overlaps are others, in the order of their numbers; then each of the sixteen elements is tested against
// those. So pairs come out in order, and each once: nothing is sorted, and no pair is found by way of two triangles,
// as it would be in a tree of triangles alone (which for a cloth on a ball holds 8.7 times as many pairs).
//
// Two edges are found from the lesser one: a node descends from its own place on. Who has a common vertex is known in
// advance (common/production_cloth/search.h).
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

// A tree, and those of its elements that one descent has reached, with the masks of whom they are no partners of;
// then those that are someone's partners, with masks of whose.
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

  // For `more` elements, and one that may be stored behind the last.
  void make_room(int more) { elements.resize(padded(2 * more)), masks.resize(padded(2 * more)); }

  // The elements that overlap the box of a node of the other tree, of nodes from `from` on, level by level. What is
  // reached is stored, and the next stored over it if it does not overlap: no branch depends on the boxes.
  void descend(int node, const Box<Real>& box, int from) {
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
    if (padded(reached * tree_width) > elements.size()) make_room(reached * tree_width);
    const int bars_nothing = barred.first[node + 1] - 1;
    for (int k = 0, row = barred.first[node]; k < reached; ++k) {
      while (barred.node[row] < nodes[k]) ++row;
      add(box, nodes[k], &barred.masks[tree_width * (barred.node[row] == nodes[k] ? row : bars_nothing)]);
    }
  }

  void add(const Box<Real>& box, int node, const std::int32_t* masks_of_children) {
    int count = this->count;  // which stays in a register
    for (int c = 0; c < tree_width; ++c) {
      const int child = node * tree_width + c;
      const bool hit = overlap(box, boxes.box(child));
      elements[count] = child, masks[count] = masks_of_children[c];
      count += hit;
    }
    this->count = count;
  }

  // Keeps those that are partners of some of sixteen elements from the first on. The compiler makes vectors of the loop
  // over the sixteen.
  void keep_partners(const Bounds<Real>& boxes_a, int first) {
    std::int32_t *const element = elements.data(), *const mask = masks.data();
    int kept = 0;
    for (int k = 0; k < count; ++k) {
      const int b = element[k];
      const Box<Real> box = boxes.box(b);
      int partners = 0;
      for (int i = 0; i < tree_width; ++i) partners |= overlap(boxes_a.box(first + i), box) << i;
      partners &= ~mask[k];
      element[kept] = b, mask[kept] = partners;
      kept += partners != 0;
    }
    count = kept;
  }
};

void add_pair(Array<ElementPair>& pairs, const ElementPair& pair) {
  const auto room = static_cast<double>(pairs.capacity());
  if (pairs.size() == pairs.capacity()) require_pairs_fit(2 * room, room);
  pairs.push_back(pair);
}

// Finds the pairs of elements of two trees, or of one.
void find(const Levels& levels_a, const Bounds<Real>& boxes_a, const Levels& levels_b, const Bounds<Real>& boxes_b,
          const Barred& barred, Array<ElementPair>& pairs) {
  const bool same = &levels_a == &levels_b;
  Reached reached(levels_b, boxes_b, barred);
  Array<std::int32_t> partners;
  pairs.clear();
  for (int node = 0; node < levels_a.nodes(); ++node) {
    reached.descend(node, boxes_a.box(levels_a.first[1] + node), same ? node : 0);
    reached.keep_partners(boxes_a, node * tree_width);
    const std::int32_t *const elements = reached.elements.data(), *const masks = reached.masks.data();
    const int count = reached.count;
    partners.resize(count + 1);
    for (int i = 0; i < tree_width; ++i) {
      int found = 0;
      for (int k = 0; k < count; ++k) partners[found] = elements[k], found += masks[k] >> i & 1;
      for (int k = 0; k < found; ++k) add_pair(pairs, {node * tree_width + i, partners[k]});
    }
  }
}

}  // namespace

void find_pairs(const Search& search, const SearchBoxes<Real>& boxes, ElementPairs& pairs) {
  find(search.vertices, boxes.vertices, search.triangles, boxes.triangles, search.point_triangle, pairs.point_triangle);
  find(search.edges, boxes.edges, search.edges, boxes.edges, search.edge_edge, pairs.edge_edge);
}

}  // namespace lockstep::production_cloth::serial
