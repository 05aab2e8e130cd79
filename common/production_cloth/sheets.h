// Cloths made by rule: sheets and tubes of triangles.
#pragma once

#include <array>

#include "common/mesh.h"

namespace lockstep::production_cloth {

// A flat rectangle, cut into squares and each of these into two triangles, whose diagonals alternate from row to row: a
// herring-bone pattern, which is as stiff along one diagonal as along the other.
struct SheetPlan {
  Vector3<double> origin;        // m: a corner
  Vector3<double> across, down;  // m: the sides from there
  std::array<int, 2> squares;    // along them, >= 1
};
Mesh make_sheet(const SheetPlan& plan);

// A tube about the line from `from` to `to`, open at both ends, cut likewise.
struct TubePlan {
  Vector3<double> from, to;    // m
  double radius;               // m
  std::array<int, 2> squares;  // around, >= 3, and along, >= 1
};
Mesh make_tube(const TubePlan& plan);

// The same mesh with vertices numbered along a Morton curve, and triangles by their least vertex. Equal ones keep their
// order.
Mesh renumbered(const Mesh& mesh);

}  // namespace lockstep::production_cloth
