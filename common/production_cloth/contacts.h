// Pairs of elements of a cloth that may meet: a point and a triangle, or two edges.
//
// Either pair has four vertices and a weight of each: a point 1 against the triangle's barycentric coordinates, or two
// points on edges. So one text serves both kinds once the vertices are known.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <vector>

#include "common/production_cloth/topology.h"

namespace lockstep::production_cloth {

// By number: of a vertex and a triangle, or of two edges a < b. Elements of a pair have no vertex in common.
struct ElementPair {
  std::int32_t a, b;
  auto operator<=>(const ElementPair&) const = default;
};

// In ascending order, each pair once.
struct ElementPairs {
  std::vector<ElementPair> point_triangle, edge_edge;
};

// The vertices of a pair: the point and the triangle's corners; the ends of the first edge and those of the second.
inline std::array<std::int32_t, 4> vertices_of_point_triangle(const Topology& t, const ElementPair& pair) {
  const std::array<std::int32_t, 3> corner = t.corners(pair.b);
  return {pair.a, corner[0], corner[1], corner[2]};
}
inline std::array<std::int32_t, 4> vertices_of_edge_edge(const Topology& t, const ElementPair& pair) {
  return {t.edges[pair.a][0], t.edges[pair.a][1], t.edges[pair.b][0], t.edges[pair.b][1]};
}

// Pairs that meet as vertices move from one position to another along straight lines, all at once from time 0 to 1.
struct Impacts {
  struct Impact {
    std::int32_t pair;  // place in the list of pairs
    float time;         // 0 to 1, not after the impact
  };
  std::vector<Impact> point_triangle, edge_edge;  // in the order of pairs
};

}  // namespace lockstep::production_cloth
