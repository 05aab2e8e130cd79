#include "common/production_cloth/topology.h"

#include <algorithm>

#include "common/input_error.h"

namespace lockstep::production_cloth {
namespace {

// An edge as a triangle has it: from one corner to the next, opposite to the corner `opposite`.
struct Side {
  std::int32_t low, high;  // its vertices
  std::int32_t triangle, opposite;
  bool ascends;  // whether the triangle runs from `low` to `high`
};

std::string name_of(const Side& side) {
  return "the edge of vertices " + std::to_string(side.low + 1) + " and " + std::to_string(side.high + 1);
}

// In the order of edges; those of an edge in the order of triangles.
std::vector<Side> sides_of(const Topology& t, const std::string& where) {
  std::vector<Side> sides;
  sides.reserve(3 * t.triangles.size());
  for (std::size_t k = 0; k < t.triangles.size(); ++k) {
    const std::array<std::int32_t, 3> corner = t.corners(k);
    for (std::int32_t c = 0; c < 3; ++c) {
      const std::int32_t from = corner[(c + 1) % 3], to = corner[(c + 2) % 3];
      const std::string triangle = where + ": triangle " + std::to_string(k + 1);
      if (from < 0 || from >= t.vertices)
        throw InputError(triangle + ": vertex " + std::to_string(from + 1) + " does not exist, expected 1 to " +
                         std::to_string(t.vertices));
      if (from == to) throw InputError(triangle + " has vertex " + std::to_string(from + 1) + " twice");
      sides.push_back({std::min(from, to), std::max(from, to), static_cast<std::int32_t>(k), c, from < to});
    }
  }
  std::ranges::sort(sides, [](const Side& a, const Side& b) {
    return std::array{a.low, a.high, a.triangle} < std::array{b.low, b.high, b.triangle};
  });
  return sides;
}

}  // namespace

Topology make_topology(int vertices, const std::vector<Triangle>& triangles, const std::string& where) {
  Topology t;
  t.vertices = vertices, t.triangles = triangles;
  t.edges_of.resize(triangles.size());

  const std::vector<Side> sides = sides_of(t, where);
  for (auto side = sides.begin(); side != sides.end();) {
    const auto end = std::find_if(
        side, sides.end(), [&](const Side& other) { return other.low != side->low || other.high != side->high; });
    if (end - side > 2)
      throw InputError(where + ": " + name_of(*side) + " is in " + std::to_string(end - side) +
                       " triangles, expected at most two");
    for (auto of = side; of != end; ++of)
      t.edges_of[of->triangle][of->opposite] = static_cast<std::int32_t>(t.edges.size());
    t.edges.push_back({side->low, side->high});
    if (end - side == 2) {
      const Side &first = side[0], &second = side[1];
      if (first.ascends == second.ascends)
        throw InputError(where + ": triangles " + std::to_string(first.triangle + 1) + " and " +
                         std::to_string(second.triangle + 1) + " turn opposite ways about " + name_of(first));
      const std::int32_t from = first.ascends ? first.low : first.high, to = first.ascends ? first.high : first.low;
      t.hinges.push_back(
          {t.corners(first.triangle)[first.opposite], t.corners(second.triangle)[second.opposite], from, to});
    }
    side = end;
  }

  std::vector<bool> has_triangle(vertices);
  for (const Triangle& triangle : triangles)
    for (const std::int32_t v : {triangle.a, triangle.b, triangle.c}) has_triangle[v] = true;
  if (const auto lone = std::ranges::find(has_triangle, false); lone != has_triangle.end())
    throw InputError(where + ": vertex " + std::to_string(lone - has_triangle.begin() + 1) + " is in no triangle");
  return t;
}

}  // namespace lockstep::production_cloth
