// The signed distance from a closed triangle mesh.
#pragma once

#include "common/levelset/field.h"
#include "common/levelset/grid.h"
#include "common/mesh.h"

namespace lockstep::levelset {

// How far from the mesh distances are exact, in spacings; all points beside the interface are nearer.
inline constexpr double exact_spacings = 3;

// The distance from a closed mesh at all points of a grid, m, negative inside; farther than exact_spacings from the mesh it is +-that.
// Which way round triangles are does not matter. Inside is what a line from outside comes to after an odd number of triangles.
Field<double> signed_distance(const Mesh& mesh, const Grid& grid);

}  // namespace lockstep::levelset
