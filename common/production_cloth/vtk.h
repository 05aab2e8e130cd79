// Frames of a production cloth for ParaView: legacy VTK poly data.
#pragma once

#include <string>

#include "common/production_cloth/bodies.h"
#include "common/production_cloth/cloth.h"

namespace lockstep::production_cloth {

// The triangles, with the velocity of vertices (m/s). Throws InputError where the file cannot be written.
void write_vtk(const std::string& path, const Topology& topology, const Motion<float>& motion);

// The surfaces of the bodies at a time. Planes are squares below the cloth. Likewise.
void write_obstacles(const std::string& path, const std::vector<Body>& bodies, double time,
                     const Vectors<float>& positions, int vertices);

}  // namespace lockstep::production_cloth
