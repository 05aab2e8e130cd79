// The muscles of a face: 16 a side, each a band of fibres in a layer under the skin.
#pragma once

#include <string>
#include <vector>

#include "common/production_face/make.h"

namespace lockstep::production_face {

// The left ones, then the right ones in the same order: "zygomaticus major left". The face looks at the viewer, so its
// left is where x > 0.
std::vector<std::string> face_muscles();

// The fibres of tetrahedra whose centroids are in a muscle, in the order of tetrahedra.
std::vector<Fibre> face_fibres(const Mesh& mesh);

}  // namespace lockstep::production_face
