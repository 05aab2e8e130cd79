// Where the points of a field stand.
#pragma once

#include "common/vector3.h"

namespace lockstep::levelset {

// Points stand in the middle of cubes that fill a box, whose lowest corner is at `origin`.
struct Grid {
  int nx, ny, nz;
  double spacing;          // m
  Vector3<double> origin;  // m

  Vector3<double> position(int x, int y, int z) const {
    return {origin.x + (x + .5) * spacing, origin.y + (y + .5) * spacing, origin.z + (z + .5) * spacing};
  }
};

}  // namespace lockstep::levelset
