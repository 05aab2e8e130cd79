// Fields for ParaView.
#pragma once

#include <string>

#include "common/levelset/field.h"
#include "common/levelset/grid.h"

namespace lockstep::levelset {

// Writes a signed distance as the point data `phi` of an image, by the end of the path: `.vti` is VTK's XML with the numbers in binary,
// `.vtk` a legacy VTK binary file. Beyond +-band it is +-band: how far is `far` would drown all else. Throws InputError where the path
// ends otherwise, or the file cannot be written, and then leaves nothing behind.
void write_image(const std::string& path, const Field<float>& signed_distance, const Grid& grid, float band);

}  // namespace lockstep::levelset
