// Frames for ParaView.
#pragma once

#include <string>

#include "common/production_fluid/particles.h"

namespace lockstep::production_fluid {

// Writes a field at the centres of cells as the point data `phi`, m, of a .vti or .vtk file (common/levelset/vti.h),
// clamped to +-band, m. Like the other functions here it throws InputError where the file cannot be written, and then
// leaves nothing behind.
void write_vtk(const std::string& path, const Field<float>& field, float band);

// Writes particles as points with radius (m) and sign, as a legacy VTK binary file.
void write_vtk(const std::string& path, const Particles<float>& particles);

// Writes drops as points with velocity (m/s) and radius (m), in such a file.
void write_vtk(const std::string& path, const Spray<float>& spray);

}  // namespace lockstep::production_fluid
