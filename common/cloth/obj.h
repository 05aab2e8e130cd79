// Triangle meshes in Wavefront OBJ.
#pragma once

#include <string>
#include <vector>

#include "common/cloth/cloth.h"

namespace lockstep::cloth {

struct Mesh {
  std::vector<Vector3<double>> points;  // in the order of the file, which numbers them from 1
  std::vector<Triangle> triangles;      // in the order of the file, polygons cut into triangles
};

// Reads points (v) and faces (f) and skips all else. Throws InputError in one line, with the line of the file or the number of the
// triangle, where the file cannot be read, does not fit the memory, has no triangle, a coordinate that is no finite number, a face
// with less than three corners, one point twice or an index out of range, the same triangle twice (whichever corner comes first,
// whichever way round), or a point in no triangle, as a file cut short has.
Mesh read_obj(const std::string& path);

}  // namespace lockstep::cloth
