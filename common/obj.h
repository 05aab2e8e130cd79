// Triangle meshes in Wavefront OBJ.
#pragma once

#include <string>

#include "common/mesh.h"

namespace lockstep {

// Reads points (v) and faces (f) and skips all else. Points are in the order of the file, which numbers them from 1; so are triangles,
// polygons cut into triangles. Throws InputError in one line, with the line of the file or the number of the triangle, where the file
// cannot be read, does not fit the memory, has no triangle, a coordinate that is no number from -1e9 to 1e9, a face with less than three
// corners, more than 255, one point twice or an index out of range, a polygon that cannot be cut, the same triangle twice (whichever
// corner comes first, whichever way round), or a point in no triangle, as a file cut short has.
Mesh read_obj(const std::string& path);

}  // namespace lockstep
