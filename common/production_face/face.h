// A face of flesh and muscles on a skull and a jaw, made on demand. Its shapes (head.h) and muscles (face_muscles.h)
// are ours; its tetrahedra are made by isosurface stuffing (stuffing.h).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/production_face/make.h"

namespace lockstep::production_face {

struct FaceMesh {
  Mesh mesh;
  std::vector<Fibre> fibres;         // in the order of their tetrahedra
  std::vector<std::string> muscles;  // their names
  // Nodes that move with the skull, and with the jaw: those on the bone and, with the skull, behind the ears.
  // Ascending. No tetrahedron has nodes of both, and none has nodes of these alone.
  std::vector<std::int32_t> skull, jaw;
};

inline constexpr Vector3<double> jaw_joint = {0, -.005, .01};  // the middle of the axis that the jaw turns about
inline constexpr double least_face_spacing = .0015, most_face_spacing = .012;

// spacing: of the lattice, from 1.5 to 12 mm; 11.5, 5.8 and 2.81 mm make 6, 46 and 381 thousand tetrahedra. Nodes
// and tetrahedra are their own mirror image about x = 0, to the bit. Nodes are numbered in layers from below, and
// tetrahedra by their least node, so that neighbours are near in memory.
FaceMesh make_face_mesh(double spacing);

// An estimate of the number of tetrahedra, rather too high: to ask for memory.
double face_tetrahedra(double spacing);

}  // namespace lockstep::production_face
