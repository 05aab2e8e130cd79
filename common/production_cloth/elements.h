// Pairs of elements of a cloth that may meet: a vertex and a triangle, or two edges. The two have no vertex in common.
#pragma once

#include <array>
#include <compare>
#include <cstdint>

#include "common/arrays.h"
#include "common/production_cloth/topology.h"

namespace lockstep::production_cloth {

struct ElementPair {
  std::int32_t a, b;
  auto operator<=>(const ElementPair&) const = default;
};

template <Same<ElementPair> P, class F>
void for_each_field(P& pair, const F& f) {
  f("a", pair.a), f("b", pair.b);
}

// Each pair once, in the order of (a, b).
struct ElementPairs {
  Array<ElementPair> point_triangle;  // a vertex and a triangle
  Array<ElementPair> edge_edge;       // edges, a < b
};

template <Same<ElementPairs> P, class F>
void for_each_array(P& pairs, const F& f) {
  f("point_triangle", pairs.point_triangle, pairs.point_triangle.size());
  f("edge_edge", pairs.edge_edge, pairs.edge_edge.size());
}

// The four vertices of a pair: the point, then the triangle's corners; or the first edge's ends, then the second's.
inline std::array<std::int32_t, 4> corners_of_point_triangle(const Topology& topology, const ElementPair& pair) {
  const auto corner = topology.corners(pair.b);
  return {pair.a, corner[0], corner[1], corner[2]};
}
inline std::array<std::int32_t, 4> corners_of_edge_edge(const Topology& topology, const ElementPair& pair) {
  const auto &e = topology.edges[pair.a], &f = topology.edges[pair.b];
  return {e[0], e[1], f[0], f[1]};
}

}  // namespace lockstep::production_cloth
