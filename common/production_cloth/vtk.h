// Frames for ParaView.
#pragma once

#include <string>
#include <vector>

#include "common/production_cloth/bodies.h"
#include "common/production_cloth/cloth.h"

namespace lockstep::production_cloth {

// Writes the triangles of a cloth, its vertices with their velocity (m/s), as a legacy VTK binary file. Throws
// InputError where the file cannot be written, and then leaves nothing behind; so does the next.
void write_vtk(const std::string& path, const Topology& topology, const Motion<float>& motion);

// Writes the bodies where they are at `time`, s, as polygons. Planes reach beyond the cloth as it is.
void write_obstacles(const std::string& path, const std::vector<Body>& bodies, double time,
                     const Vectors<float>& position, int vertices);

}  // namespace lockstep::production_cloth
