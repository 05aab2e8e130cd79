// Makes a cloth: particles, constraints, batches and triangles from the plan of a sheet or of a mesh.
#pragma once

#include <span>
#include <vector>

#include "common/cloth/cloth.h"

namespace lockstep::cloth {

// A flat sheet of evenly spaced particles: (row, column) is at origin + row * down + column * across.
struct SheetPlan {
  int rows, columns;             // >= 1, together >= 2 particles
  Vector3<double> origin;        // m
  Vector3<double> across, down;  // m: from one column, one row, to the next
  double mass;                   // kg, of all particles together, > 0
  bool bending;                  // whether there are constraints between particles two apart, too
  std::vector<int> pinned;       // particles row * columns + column that do not move; a number may come twice
};

// Constraints: to the particles below, to the right, and on both diagonals; with bending, to those two below and two to
// the right; none between two pinned particles. They are listed particle by particle, left to right and top to bottom.
// Triangles: two a square of four particles.
Cloth<double> make_sheet(const Model<double>& model, const Bodies<double>& bodies, const SheetPlan& plan);

// A cloth of any triangles, in any arrangement: open, closed, with edges of one triangle or of many.
struct MeshPlan {
  std::vector<Vector3<double>> points;  // m; no two points of a constraint may coincide
  std::vector<Triangle> triangles;      // of points, three different ones each
  double mass;                          // kg, of all points together, > 0
  bool bending;             // whether the far corners of two triangles with a common edge get a constraint, too
  std::vector<int> pinned;  // points that do not move; a number may come twice
};

// Constraints: the edges, each once, in the order of the triangles; then those of bending in the order of their edges;
// none between two pinned points. Where more than two triangles share an edge, bending constrains each with the next.
Cloth<double> make_mesh(const Model<double>& model, const Bodies<double>& bodies, const MeshPlan& plan);

// A cloth in another precision; widening is exact.
template <class To, class From>
Cloth<To> convert(const Cloth<From>& cloth);

}  // namespace lockstep::cloth
