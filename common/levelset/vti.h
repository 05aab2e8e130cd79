// Fields for ParaView.
#pragma once

#include <string>

#include "common/levelset/field.h"
#include "common/levelset/grid.h"

namespace lockstep::levelset {

// Writes a signed distance (m) as the point data `phi` of an image, a .vti or a .vtk file (common/vtk.h). Values are
// clamped to +-band (m), since the large value of points never reached would drown all others. Throws InputError where
// the path ends otherwise or the file cannot be written, and then leaves nothing behind.
void write_image(const std::string& path, const Field<float>& signed_distance, const Grid& grid, float band);

}  // namespace lockstep::levelset
