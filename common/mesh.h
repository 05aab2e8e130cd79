// Triangle meshes.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/vector3.h"

namespace lockstep {

struct Triangle {
  std::int32_t a, b, c;
};

struct Mesh {
  std::vector<Vector3<double>> points;  // m
  std::vector<Triangle> triangles;      // of points
};

// Throws InputError, in one line that begins with `where`, unless every edge is an edge of exactly two triangles: only
// then is there an inside.
void require_closed(const Mesh& mesh, const std::string& where);

}  // namespace lockstep
