// How a grid and a mesh fit each other.
#pragma once

#include <array>
#include <string>

#include "common/levelset/grid.h"
#include "common/mesh.h"

namespace lockstep::levelset {

// The finest grid of so many points that has the mesh in its middle and `room` spacings between it and each side.
// Throws InputError, which `where` opens, unless there are points for the room and the spacing is 1e-6 .. 1e6 m.
Grid fit_grid(const Mesh& mesh, const std::array<int, 3>& points, double room, const std::string& where);

// Throws InputError, which `where` opens and which names both boxes, if the mesh reaches beyond the grid's box.
void require_inside(const Mesh& mesh, const Grid& grid, const std::string& where);

}  // namespace lockstep::levelset
