// Frames for ParaView.
#pragma once

#include <string>

#include "common/cloth/cloth.h"

namespace lockstep::cloth {

// Writes the particles, a sheet's row by row without its padding, with their velocity (m/s) and the triangles between
// them, or the line along a rope, as a legacy VTK binary file. Throws InputError where the file cannot be written, and
// then leaves nothing behind.
void write_vtk(const std::string& path, const Cloth<float>& cloth);

}  // namespace lockstep::cloth
