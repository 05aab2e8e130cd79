// Frames for ParaView.
#pragma once

#include <string>

#include "common/rigid/world.h"

namespace lockstep::rigid {

// What of a world a file of surfaces shows: bodies that move, static ones without the planes, planes.
enum class Part { moving, fixed, planes };

// Whether a world has anything of it.
bool has(const World<float>& world, Part part);

// Each writes a legacy VTK binary file. It throws InputError where the file cannot be written, and then leaves nothing
// behind.

// The surfaces of a part's colliders as polygons, with the number (`body`) and the speed (m/s) of the body at each.
// Spheres and capsules have eight sides, triangles of meshes one side. Planes are squares that reach beyond all other
// colliders.
void write_surfaces(const std::string& path, const World<float>& world, Part part);

// All bodies by number, each as a point at its centre of mass, with
//   orientation_wxyz   a unit quaternion, w first, as VTK's glyphs take it
//   velocity           m/s
//   angular_velocity   rad/s
//   mass               kg; 0 for a static body
//   kind               of its collider: 0 sphere, 1 capsule, 2 box, 3 hull, 4 triangle, of a mesh, 5 plane; 6 where it
//                      has several kinds, or several colliders that are no mesh
//   body               its number
void write_bodies(const std::string& path, const World<float>& world);

}  // namespace lockstep::rigid
