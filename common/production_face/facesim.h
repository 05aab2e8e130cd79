// The face of PARSEC's facesim, from the files that the program reads: tetrahedra, muscles, what bones hold, and frames
// of muscles' activation and bones' places.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/production_face/mesh_file.h"
#include "common/production_face/motion.h"

namespace lockstep::production_face {

struct FacesimFace {
  MeshFile file;
  std::vector<Fibre> fibres;         // in the order of their tetrahedra
  std::vector<std::string> muscles;  // their names
  std::vector<Bone> bones;           // of the names of attachments; that named jaw turns about the middle of its joint
  std::vector<std::vector<std::int32_t>> held;  // nodes, by each bone; a node in several lists is the last one's
  std::vector<Key> keys;                        // a frame apart from 0 on; none without controls
};

// Numbers are little-endian, whole ones of 4 bytes, others float; an array is how many there are, then they. Nodes and
// tetrahedra are counted from 1. N nodes, T tetrahedra. In `folder`:
// - face_simulation.tet, or, where it is missing, face_simulation_1.tet and particle_positions_1.dat
//                            N; 4, T and T times 4 nodes; a byte 1; N, N, 0; three bytes; N and N places, m
//                            an array: which node of the .tet each node of the attachments is
// - muscle_list.txt          how many, then names
// - NAME.constitutive_data   arrays of a muscle's tetrahedra, of its fibres' directions, of its shares of tetrahedra
// - peak_isometric_stress_list.txt   how many, then names of muscles and Pa; other muscles have `muscle_stress`
// - attachment_list.txt      how many, then names, of which one is jaw
// - NAME.attached_nodes      an array of nodes
// - jaw_joint_parameters     the joint's middle, m; its normal, axis and front; length of the axis, and of sliding, m
// and in `controls`, where it is given, for k = 0, 1, ... as long as there are files:
// - storytelling_controls.k  an array of the muscles' activation, then of the cranium and the jaw each a rotation, by
//                            columns, and a shift: the jaw's place in the cranium's frame; an array of as many bytes
//
// facesim's rigid bodies, against which flesh is pressed, are not read. Throws InputError in one line where
// - a file is missing, is longer or shorter than it says, or does not fit the memory
// - a node or a tetrahedron that is named does not exist; a name comes twice in a list, or a tetrahedron in a muscle
// - a number is beyond 1e9; a share or an activation is outside 0 to 1 by more than .001 (by less, it is clamped)
// - a direction's length differs from 1 by more than .1, or a singular value of a rotation by more than .01
// - the mesh has a fault (faults.h)
FacesimFace read_facesim(const std::string& folder, const std::optional<std::string>& controls);

}  // namespace lockstep::production_face
