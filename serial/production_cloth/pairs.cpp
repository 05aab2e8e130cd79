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

#include <utility>

#include "common/real.h"
#include "common/spatial/pairs.h"

namespace lockstep::production_cloth::serial {
namespace {

using namespace spatial;

// A tree, and what a node of the other has reached in it: elements, with masks of whom they are no partners of; then
// those that are someone's partners, with masks of whose.
struct Reached {
  const Levels& levels;
  const Bounds<Real>& boxes;
  const Barred& barred;
  int blocks = 0, node_count = 0, count = 0;
  Array<std::int32_t> block = {}, above = {}, nodes = {}, elements = {}, masks = {};

  Reached(const Levels& levels, const Bounds<Real>& boxes, const Barred& barred)
      : levels(levels), boxes(boxes), barred(barred) {
    const int most_blocks = levels.nodes() / tree_width + 1;
    block.resize(padded(most_blocks)), above.resize(padded(most_blocks));
    nodes.resize(padded(levels.nodes()));
    make_room(tree_width);
  }

  // For `more` elements, and for one that may be stored behind the last.
  void make_room(int more) {
    for (Array<std::int32_t>* array : {&elements, &masks}) array->resize(padded(2 * more));
  }

  // Stores which of the sixteen children of a node overlap a box and are of nodes from `from` on. Says how many. Every
  // child is stored, and the next over it if it is none of those: no branch depends on the boxes.
  int children(int level, int parent, const Box<Real>& box, int from, std::int32_t* to) const {
    const int child = parent * tree_width;
    int count = 0;
    for (int number = child; number < child + tree_width; ++number) {
      const bool after = number >= from >> 4 * (level - 1);
      const bool hit = after & overlap(box, boxes.box(levels.first[level] + number));
      to[count] = number;
      count += hit;
    }
    return count;
  }

  // The blocks of sixteen nodes that overlap the box of a node, of nodes from `from` on, level by level.
  void descend(const Box<Real>& box, int from) {
    block[0] = 0, blocks = 1;
    for (int level = levels.last(); level >= 2; --level) {
      block.swap(above);
      const int parents = std::exchange(blocks, 0);
      for (int k = 0; k < parents; ++k) blocks += children(level, above[k], box, from, &block[blocks]);
    }
  }

  // The nodes of these blocks that overlap it.
  void reach_nodes(const Box<Real>& box, int from) {
    int to = 0;
    for (int k = 0; k < blocks; ++k) to += children(1, block[k], box, from, &nodes[to]);
    node_count = to;
  }

  // The elements of these nodes that overlap it. The node is that of the other tree.
  void reach_elements(int node, const Box<Real>& box) {
    const int bars_nothing = barred.first[node + 1] - 1;
    int to = 0;
    for (int k = 0, row = barred.first[node]; k < node_count; ++k) {
      while (barred.node[row] < nodes[k]) ++row;
      add(box, nodes[k], &barred.masks[tree_width * (barred.node[row] == nodes[k] ? row : bars_nothing)], to);
    }
    count = to;
  }

  void add(const Box<Real>& box, int node, const std::int32_t* masks_of_children, int& count) {
    for (int c = 0; c < tree_width; ++c) {
      const int child = node * tree_width + c;
      const bool hit = overlap(box, boxes.box(child));
      elements[count] = child;
      masks[count] = masks_of_children[c];
      count += hit;
    }
  }

  // Keeps those that are partners of some of sixteen elements from the first on. The compiler makes vectors of the loop
  // over the sixteen.
  void keep_partners(const Bounds<Real>& boxes_a, int first_a) {
    std::int32_t *const element = elements.data(), *const mask = masks.data();
    const int n = count;
    int kept = 0;
    for (int k = 0; k < n; ++k) {
      const int b = element[k];
      const Box<Real> box = boxes.box(b);
      int partners = 0;
      for (int i = 0; i < tree_width; ++i) partners |= overlap(boxes_a.box(first_a + i), box) << i;
      partners &= ~mask[k];
      element[kept] = b;
      mask[kept] = partners;
      kept += partners != 0;
    }
    count = kept;
  }
};

// Finds the pairs of elements of two trees, or of one.
void find(const Levels& levels_a, const Bounds<Real>& boxes_a, const Levels& levels_b, const Bounds<Real>& boxes_b,
          const Barred& barred, Array<ElementPair>& pairs) {
  const bool same = &levels_a == &levels_b;
  Reached reached(levels_b, boxes_b, barred);
  Array<std::int32_t> partners;
  pairs.clear();
  for (int node = 0; node < levels_a.nodes(); ++node) {
    const Box<Real> box = boxes_a.box(levels_a.first[1] + node);
    reached.descend(box, same ? node : 0);
    reached.reach_nodes(box, same ? node : 0);
    const int most = reached.node_count * tree_width;
    if (padded(most) > reached.elements.size()) reached.make_room(most);
    reached.reach_elements(node, box);
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
