// A face for ParaView.
#pragma once

#include <string>

#include "common/production_face/body.h"

namespace lockstep::production_face {

// Tetrahedra at their deformed places, with each node's displacement (m) and each tetrahedron's
//   stretch     its greatest singular value
//   volume      over that at rest; negative where it is inside out
//   quality     of the deformed tetrahedron, 6 sqrt(2) volume over the cube of its longest edge: 1 if regular
//   activation  the greatest of its muscles', times its share of muscle
// Throws InputError where the file cannot be written.
void write_vtk(const std::string& path, const Body<float>& body, const Pose<float>& pose);

}  // namespace lockstep::production_face
