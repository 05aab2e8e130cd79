// Trees of boxes over a cloth's vertices, edges and triangles: what the search for pairs descends.
//
// Elements stand in the order of their numbers, which follow a Morton curve on the cloth at rest (load_scene): what is
// near in number is near on the cloth, and stays so however the cloth folds. So a tree is never sorted, its topology
// follows from how many elements there are, and pairs come out in order. Other numberings are as correct, but slower.
//
// Level 0 has the boxes of the elements. Box i of each further level is the smallest around boxes 16 i .. 16 i + 15 of
// the level below. The last level is at least level 1, and has sixteen boxes at most. Each level is padded with empty
// boxes to whole nodes, so that a node is always sixteen boxes side by side (common/spatial/tree.h has a picture).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/arrays.h"
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

// What the search needs of a topology, made once. Arrays are padded to whole nodes.
struct Search {
  Levels vertices, edges, triangles;
  std::array<Array<std::int32_t>, 2> ends;     // [k][edge]
  std::array<Array<std::int32_t>, 3> corners;  // [k][triangle]
};

inline Search make_search(const Topology& topology) {
  Search search = {make_levels(topology.vertices),
                   make_levels(static_cast<int>(topology.edges.size())),
                   make_levels(static_cast<int>(topology.triangles.size())),
                   {},
                   {}};
  for (int k = 0; k < 2; ++k) {
    search.ends[k].resize(padded(topology.edges.size()));
    for (std::size_t e = 0; e < topology.edges.size(); ++e) search.ends[k][e] = topology.edges[e][k];
  }
  for (int k = 0; k < 3; ++k) {
    search.corners[k].resize(padded(topology.triangles.size()));
    for (std::size_t t = 0; t < topology.triangles.size(); ++t) search.corners[k][t] = topology.corners(t)[k];
  }
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
