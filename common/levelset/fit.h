// How a grid and a mesh fit each other.
#pragma once

#include <array>
#include <string>

#include "common/levelset/grid.h"
#include "common/mesh.h"

namespace lockstep::levelset {

// The finest grid of `points` points along each axis that has the mesh in its middle and at least `room` spacings
// between it and each side. Throws InputError, which begins with `where`, unless there are points for the room, the
// spacing is 1e-6 .. 1e6 m, and the mesh's coordinates are at most 1e9 spacings.
Grid fit_grid(const Mesh& mesh, const std::array<int, 3>& points, double room, const std::string& where);

// Throws InputError, which begins with `where` and names both boxes, if the mesh reaches beyond the grid's box.
void require_inside(const Mesh& mesh, const Grid& grid, const std::string& where);

}  // namespace lockstep::levelset
