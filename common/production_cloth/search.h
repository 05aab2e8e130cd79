// Trees of boxes over a cloth's vertices, edges and triangles: what the search for pairs descends.
//
// Elements stand in the order of their numbers, which follow a Morton curve on the cloth at rest (load_scene): what is
// near in number is near on the cloth, and stays so however the cloth folds. So a tree is never sorted, its topology
// follows from how many elements there are, and pairs come out in order. Other numberings are as correct.
//
// Level 0 has the boxes of the elements. Box i of each further level is the smallest around boxes 16 i .. 16 i + 15 of
// the level below. The last level is at least level 1, and has sixteen boxes at most. Each level is padded with empty
// boxes to whole nodes, so that a node is always sixteen boxes side by side (common/spatial/tree.h has a picture).
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include "common/arrays.h"
#include "common/counting_sort.h"
#include "common/production_cloth/topology.h"
#include "common/spatial/bounds.h"
#include "common/spatial/tree.h"

namespace lockstep::production_cloth {

using spatial::Bounds;
using spatial::Box;
using spatial::tree_width;

// Where the levels of a tree begin.
struct Levels {
  int elements = 0;
  std::vector<int> first;  // [level]; one more entry, where the last level ends

  int last() const { return static_cast<int>(first.size()) - 2; }
  int nodes() const { return (elements + tree_width - 1) / tree_width; }  // of level 0
};

inline Levels make_levels(int elements) {
  Levels levels = {elements, {0}};
  int boxes = elements;
  do {
    const int nodes = (boxes + tree_width - 1) / tree_width;
    levels.first.push_back(levels.first.back() + nodes * tree_width);
    boxes = nodes;
  } while (boxes > tree_width);
  levels.first.push_back(levels.first.back() + (boxes > 0 ? tree_width : 0));
  return levels;
}

// Which elements of a tree B are no partners of those of a tree A, wherever they are: those with a common vertex; and
// in one tree, so that a pair is found once, those that are not greater. For each node of A, sixteen elements, there is
// a row of masks for each node of B that has such elements; in one tree, from the node's own place on.
struct Barred {
  std::vector<int> first;          // [node of A]: its first row; one more entry, where the last one's end
  std::vector<std::int32_t> node;  // [row]: of B, ascending; then INT32_MAX: the last row of each bars nothing
  Array<std::int32_t> masks;       // [16 row + j], bit i: 16 A's node + i and 16 B's node + j are no pair
};

template <std::size_t m, std::size_t n>
Barred make_barred(int vertices, int elements_a, const std::array<Array<std::int32_t>, m>& corners_a, int elements_b,
                   const std::array<Array<std::int32_t>, n>& corners_b, bool same) {
  std::vector<std::int32_t> begin, at(n * elements_b);  // [begin[v]]: the elements of B at vertex v
  stable_counting_sort(
      vertices,
      [&](const auto& visit) {
        for (int b = 0; b < elements_b; ++b)
          for (const auto& corner : corners_b) visit(b, corner[b]);
      },
      [&](int b, int place) { at[place] = b; }, begin);
  Barred barred;
  std::vector<std::pair<int, int>> pairs;  // (b, a)
  for (int first_a = 0; first_a < elements_a; first_a += tree_width) {
    pairs.clear();
    for (int a = first_a; a < std::min(first_a + tree_width, elements_a); ++a) {
      for (const auto& corner : corners_a)
        for (int k = begin[corner[a]]; k < begin[corner[a] + 1]; ++k)
          if (!same || at[k] > a) pairs.push_back({at[k], a});
      for (int b = first_a; same && b <= a; ++b) pairs.push_back({b, a});
    }
    std::ranges::sort(pairs);
    barred.first.push_back(static_cast<int>(barred.node.size()));
    const auto add_row = [&](int node) {
      barred.node.push_back(node);
      barred.masks.insert(barred.masks.end(), tree_width, 0);
    };
    for (const auto& [b, a] : pairs) {
      if (barred.node.size() == static_cast<std::size_t>(barred.first.back()) || barred.node.back() != b / tree_width)
        add_row(b / tree_width);
      barred.masks[barred.masks.size() - tree_width + b % tree_width] |= 1 << a % tree_width;
    }
    add_row(INT32_MAX);
  }
  barred.first.push_back(static_cast<int>(barred.node.size()));
  return barred;
}

// What the search needs of a topology, made once. Arrays are padded to whole nodes.
struct Search {
  Levels vertices, edges, triangles;
  std::array<Array<std::int32_t>, 2> ends;     // of edges
  std::array<Array<std::int32_t>, 3> corners;  // of triangles
  Barred point_triangle, edge_edge;
};

inline Search make_search(const Topology& topology) {
  const int edges = static_cast<int>(topology.edges.size()), triangles = static_cast<int>(topology.triangles.size());
  Search search = {make_levels(topology.vertices), make_levels(edges), make_levels(triangles), {}, {}, {}, {}};
  for (int k = 0; k < 2; ++k) {
    search.ends[k].resize(padded(edges));
    for (int e = 0; e < edges; ++e) search.ends[k][e] = topology.edges[e][k];
  }
  for (int k = 0; k < 3; ++k) {
    search.corners[k].resize(padded(triangles));
    for (int t = 0; t < triangles; ++t) search.corners[k][t] = topology.corners(t)[k];
  }
  std::array<Array<std::int32_t>, 1> points = {Array<std::int32_t>(topology.vertices)};
  std::iota(points[0].begin(), points[0].end(), 0);
  search.point_triangle = make_barred(topology.vertices, topology.vertices, points, triangles, search.corners, false);
  search.edge_edge = make_barred(topology.vertices, edges, search.ends, edges, search.ends, true);
  return search;
}

// The boxes of all levels, the lowest first.
template <class Real>
struct SearchBoxes {
  Bounds<Real> vertices, edges, triangles;

  // Room for the boxes of a search. What is there already is kept.
  void resize(const Search& search) {
    const auto fit = [](const Levels& levels, Bounds<Real>& boxes) {
      if (boxes.count != levels.first.back()) boxes.resize(levels.first.back());
    };
    fit(search.vertices, vertices), fit(search.edges, edges), fit(search.triangles, triangles);
  }
};

template <Is<SearchBoxes> B, class F>
void for_each_array(B& boxes, const F& f) {
  f("vertices.low", boxes.vertices.low, boxes.vertices.count),
      f("vertices.high", boxes.vertices.high, boxes.vertices.count);
  f("edges.low", boxes.edges.low, boxes.edges.count), f("edges.high", boxes.edges.high, boxes.edges.count);
  f("triangles.low", boxes.triangles.low, boxes.triangles.count);
  f("triangles.high", boxes.triangles.high, boxes.triangles.count);
}

}  // namespace lockstep::production_cloth
