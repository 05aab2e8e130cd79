// Triangle meshes in files.
#pragma once

#include <string>

#include "common/mesh.h"

namespace lockstep {

// Reads a file by its extension, in letters of either case:
// - .obj  Wavefront OBJ: points (v) and faces (f)
// - .off  OFF in text, also COFF, NOFF and CNOFF: the first three numbers of each point, and the faces
// - .ply  PLY in text or binary of either byte order: x, y and z of each vertex, and the list vertex_indices (or
//         vertex_index) of each face
// - .stl  STL in text or binary; corners with the same coordinates are one point
// All else that the file says is skipped. Coordinates are in m. Points and triangles are in the order of the file;
// messages number points, faces and lines from 1. Polygons are cut into triangles, convex ones into fans from their
// first corner. Throws InputError in one line, with the line of the file or the number of the face, where
// - the extension is another, the file cannot be read, is not of its format, ends early, does not fit the memory or has
//   no triangle
// - a coordinate is not a number from -1e9 to 1e9
// - a face has fewer than 3 corners, more than 255, one point twice or an index out of range
// - a polygon cannot be cut: it has no area, or crosses itself
// - a triangle comes twice, whichever corner is first and whichever way round
// - a point is in no triangle, as in a file cut short
Mesh read_mesh(const std::string& path);

// Bytes of memory that reading may take per byte of the file. Files of nothing but the shortest polygons took 16.
inline constexpr double mesh_bytes_per_byte = 25;

// Those of one format, whatever the extension.
Mesh read_obj(const std::string& path);
Mesh read_off(const std::string& path);
Mesh read_ply(const std::string& path);
Mesh read_stl(const std::string& path);

}  // namespace lockstep
