// Frames for ParaView.
#pragma once

#include <string>

#include "common/rigid/world.h"

namespace lockstep::rigid {

// Writes the surfaces of all colliders as the polygons of a legacy VTK binary file, with the number and the speed (m/s)
// of the body at each. Spheres and capsules have eight sides, planes are squares beneath all else, triangles of meshes
// have one side. Throws InputError where the file cannot be written, and then leaves nothing behind.
void write_vtk(const std::string& path, const World<float>& world);

}  // namespace lockstep::rigid
