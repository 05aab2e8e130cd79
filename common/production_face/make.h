// Bodies made of nodes and tetrahedra.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/production_face/body.h"

namespace lockstep::production_face {

// Positions at rest, m, and the corners of tetrahedra.
struct Mesh {
  std::vector<Vector3<double>> nodes;
  std::vector<std::array<std::int32_t, 4>> tetrahedra;
};

// The fibre of a muscle in a tetrahedron.
struct Fibre {
  std::int32_t tetrahedron, muscle;
  Vector3<double> direction;      // at rest; of length 1
  double share = 1;               // of the tetrahedron that is muscle, 0 to 1
  double stress = muscle_stress;  // the greatest tension, Pa
};

// A box of cells, filled by a body-centred cubic lattice: nodes at the corners and in the middle of cells, four
// tetrahedra about each face between two cells and two at each face of the box. All have a volume of spacing^3 / 12.
// Source: Labelle and Shewchuk, Isosurface stuffing, SIGGRAPH 2007; the sides of the box are ours.
Mesh make_lattice(const std::array<int, 3>& cells, double spacing);

// The mesh must have no fault (faults.h); fibres stand in the order of their tetrahedra.
Body<float> make_body(const Mesh& mesh, const std::vector<Fibre>& fibres, int muscles);

// In another precision, its gradients and volumes computed anew from the same positions.
Body<double> in_double(const Body<float>& body);

}  // namespace lockstep::production_face
