// Frames for ParaView.
#pragma once

#include <span>
#include <string>

#include "common/cloth/cloth.h"
#include "common/surfaces.h"

namespace lockstep::cloth {

// Writes the particles of one or more cloths, a sheet's row by row without its padding, with their velocity (m/s) and
// the triangles between them, or the line along a rope, as a legacy VTK binary file. Throws InputError where the file
// cannot be written, and then leaves nothing behind.
void write_vtk(const std::string& path, std::span<const Cloth<float>> cloths);

// Writes the bodies that these cloths collide with, as large as they find them (with the scene's `thickness`), as
// polygons of such a file. Spheres and capsules have 32 sides; planes are squares that reach beyond the cloths.
void write_obstacles(const std::string& path, std::span<const Cloth<float>> cloths);

// The same polygons of any bodies; planes reach beyond the box from low to high.
Surfaces surfaces_of(const Bodies<float>& bodies, const Vector3<float>& low, const Vector3<float>& high);

// Writes such a file.
void write_surfaces(const std::string& path, const Surfaces& surfaces);

}  // namespace lockstep::cloth
