// Fills a shape with tetrahedra of bounded angles.
//
// A body-centred cubic lattice (corners and middles of cells) is laid over the shape. Its edges are long, from a corner
// or middle to the next of its kind, or short, between a corner and a middle. Where an edge leaves the shape is a cut.
// A lattice point with a cut nearer than .24999 of a long edge or .41189 of a short one moves to the cut, and is then
// on the surface. What is inside of a tetrahedron with corners inside and outside is a simpler shape of corners and
// cuts, which a table fills. Dihedral angles then are from 10.7 to 164.8 degrees.
//
// The shape must be its own mirror image about x = 0, and the mesh is, too, to the bit: half of it is made, and what
// crosses the middle is made alike on both sides. The published table cannot do that where a face with four corners is
// its own mirror image, since either diagonal of it breaks the symmetry: a node in its middle cuts it into four. And
// points in the middle move within it. The published bounds on angles do not cover these tetrahedra; tests print
// theirs.
//
// Source: Labelle and Shewchuk, Isosurface stuffing: fast tetrahedral meshes with good dihedral angles, SIGGRAPH 2007.
// The symmetry is ours.
#pragma once

#include <functional>

#include "common/production_face/make.h"

namespace lockstep::production_face {

// Negative inside of a shape, positive outside.
using Distance = std::function<double(const Vector3<double>&)>;

// `distance` depends on |x| alone, and is positive where |x| > half_width, and outside of low and high in y and z. A
// corner of a cell is at (0, low_y, low_z). Tetrahedra have positive volumes; each node is in one.
struct StuffedBox {
  double half_width, low_y, high_y, low_z, high_z, spacing;  // m
};
Mesh stuff(const Distance& distance, const StuffedBox& box);

}  // namespace lockstep::production_face
