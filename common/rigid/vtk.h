// Frames for ParaView.
#pragma once

#include <string>

#include "common/rigid/world.h"

namespace lockstep::rigid {

// Writes the surfaces of all colliders, where their bodies are, as polygons: with the number of the body, and its speed, m/s, of each. As a
// legacy VTK binary file. Spheres and capsules are drawn with eight sides, planes as squares around all else, triangles of meshes with one
// side. Throws InputError where the file cannot be written, and then leaves nothing behind.
void write_vtk(const std::string& path, const World<float>& world);

}  // namespace lockstep::rigid
