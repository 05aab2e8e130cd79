// Triangle meshes in Wavefront OBJ.
#pragma once

#include <string>

#include "common/mesh.h"

namespace lockstep {

// Reads points (v, m) and faces (f) and skips all else. Points and triangles are in the order of the file, which
// numbers points from 1. Polygons are cut into triangles, convex ones into fans from their first corner. Throws
// InputError in one line, with the line of the file or the number of the triangle, where
// - the file cannot be read, does not fit the memory or has no triangle
// - a coordinate is not a number from -1e9 to 1e9
// - a face has fewer than 3 corners, more than 255, one point twice or an index out of range
// - a polygon cannot be cut: it has no area, or crosses itself
// - a triangle comes twice, whichever corner is first and whichever way round
// - a point is in no triangle, as in a file cut short
Mesh read_obj(const std::string& path);

}  // namespace lockstep
