// Tetrahedral meshes in text files.
#pragma once

#include <string>

#include "common/production_face/make.h"

namespace lockstep::production_face {

struct MeshFile {
  Mesh mesh;        // in the order of the file, places rounded to float
  int turned = 0;   // tetrahedra that had a negative volume: two of their corners are swapped
  int doubled = 0;  // nodes that stand where another does: a cut runs between the two (faults.h)
};

// Rounds places to float, turns and counts. Throws InputError, which begins with the path, where the mesh still has a
// fault.
MeshFile mended(Mesh mesh, const std::string& path);

// Reads a file by its extension, in letters of either case:
// - .node, .ele  TetGen: both files, of which either is named
// - .msh         Gmsh 2.2 or 4.1: elements of type 4
// - .vtk         legacy VTK, unstructured grids up to version 5.1: cells of type 10
// - .veg         Vega: *VERTICES, and *ELEMENTS TET
// All else that the file says is skipped, other elements too. Coordinates are in m. Throws InputError in one line, with
// the line of the file where there is one, where
// - the extension is another, the file cannot be read, is not of its format or binary, ends early, does not fit the
//   memory or has no tetrahedron
// - a coordinate is not a number from -1e9 to 1e9
// - two nodes have one number, or a node is in no tetrahedron
// - a tetrahedron has a corner that is no node, a node twice, or the nodes of another; no volume, less than 1e-4 of its
//   longest edge cubed, or no edge of 1e-6 m or longer
MeshFile read_mesh(const std::string& path);

}  // namespace lockstep::production_face
