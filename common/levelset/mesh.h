// The signed distance from a closed triangle mesh.
#pragma once

#include "common/levelset/field.h"
#include "common/levelset/grid.h"
#include "common/mesh.h"

namespace lockstep::levelset {

// How far from the mesh distances are exact, in spacings, unless told otherwise; all points beside the interface are
// nearer.
inline constexpr double exact_spacings = 3;

// The distance (m) from a closed mesh at all points of a grid, negative inside, clamped to +-`exact` spacings. A point
// is inside if a line to it from outside crosses an odd number of triangles; their orientation does not matter.
Field<double> signed_distance(const Mesh& mesh, const Grid& grid, double exact = exact_spacings);

}  // namespace lockstep::levelset
