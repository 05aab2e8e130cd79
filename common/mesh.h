// Triangle meshes.
#pragma once

#include <cstdint>
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

}  // namespace lockstep
