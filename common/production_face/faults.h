// What is wrong with a mesh.
#pragma once

#include <string>

#include "common/production_face/make.h"

namespace lockstep::production_face {

// A tetrahedron is a sliver where its volume is less than this share of the cube of its longest edge, L; a regular one
// has .118. A gradient is no longer than a face over three times the volume, .144 / (share L). F has three times two
// displacements d, each rounded by u d, times a gradient: it is off by up to .87 u d / (share L). Here that is 5e-4 of
// d / L, a strain of which kappa makes a hundredth of the stress with which flesh resists a shear of d / L.
inline constexpr double least_share = 1e-4;
inline constexpr double least_edge = 1e-6;  // m, of a tetrahedron's longest edge: smaller volumes leave float's range

// In words: no tetrahedra, a corner out of range or twice, a volume that is not positive, a sliver, a tetrahedron too
// small or that comes twice, a node without a tetrahedron, a position that is not finite; "" if nothing is.
std::string fault_of(const Mesh& mesh);

// Swaps two corners of tetrahedra with a negative volume. Returns how many those are.
int turn_inside_out(Mesh& mesh);

// How many nodes stand exactly where one before them does. Nothing joins two such nodes: a cut runs between them.
int count_doubled(const Mesh& mesh);

}  // namespace lockstep::production_face
