// The triangles of a cloth, and what follows from them: edges and hinges.
//
// A cloth is a manifold: an edge belongs to one triangle or to two, and two that share it turn the same way. It may
// consist of several sheets.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "common/mesh.h"

namespace lockstep::production_cloth {

struct Topology {
  int vertices = 0;
  std::vector<Triangle> triangles;

  std::vector<std::array<std::int32_t, 2>> edges;     // vertices a < b; in the order of (a, b)
  std::vector<std::array<std::int32_t, 3>> edges_of;  // [triangle][c]: the edge opposite to its corner c

  // Two triangles with a common edge. Vertices 2 and 3 are the edge's, 0 and 1 the far ones: the first triangle is
  // (0, 2, 3) and the second (1, 3, 2), turned as the mesh has them. In the order of their edges.
  std::vector<std::array<std::int32_t, 4>> hinges;

  std::array<std::int32_t, 3> corners(std::size_t triangle) const {
    return {triangles[triangle].a, triangles[triangle].b, triangles[triangle].c};
  }
};

// Throws InputError, in one line that begins with `where`, if a corner is no vertex, a triangle has a corner twice, an
// edge belongs to more than two triangles, two triangles with a common edge turn opposite ways, or a vertex belongs to
// no triangle. Triangles, corners and vertices are counted from 1 in messages.
Topology make_topology(int vertices, const std::vector<Triangle>& triangles, const std::string& where);

}  // namespace lockstep::production_cloth
