// Making a cloth: particles, constraints, batches and triangles from a sheet's plan or a mesh.
#pragma once

#include <span>
#include <vector>

#include "common/cloth/cloth.h"

namespace lockstep::cloth {

// A flat sheet of evenly spaced particles: (row, column) stands at origin + row * down + column * across.
struct SheetPlan {
  int rows, columns;             // >= 1, together >= 2 particles
  Vector3<double> origin;        // m
  Vector3<double> across, down;  // m: from one column, one row, to the next
  double mass;                   // kg, of all particles together, > 0
  bool bending;                  // whether particles two apart are tied, too
  std::vector<int> pinned;       // particles row * columns + column that nothing moves; a number may come twice
};

// Ties: below, right, across both diagonals, and with bending two below and two to the right, none between two pinned particles; the
// list has them particle by particle, left to right and top to bottom. Triangles: two a square of four particles.
Cloth<double> make_sheet(const Model<double>& model, const Bodies<double>& bodies, const SheetPlan& plan);

// A cloth of any triangles, in any arrangement: open, closed, with edges of one triangle or of many.
struct MeshPlan {
  std::vector<Vector3<double>> points;  // m; no two tied points may coincide
  std::vector<Triangle> triangles;      // of points, three different ones each
  double mass;                          // kg, of all points together, > 0
  bool bending;                         // whether the far corners of two triangles with a common edge are tied, too
  std::vector<int> pinned;              // points that nothing moves; a number may come twice
};

// Ties: the edges, each once, in the order in which the triangles bring them, then the bending ties in the order of their edges;
// none between two pinned points. Where more than two triangles share an edge, bending ties each with the next of them.
Cloth<double> make_mesh(const Model<double>& model, const Bodies<double>& bodies, const MeshPlan& plan);

// A cloth in another precision; widening is exact.
template <class To, class From>
Cloth<To> convert(const Cloth<From>& cloth);

}  // namespace lockstep::cloth
