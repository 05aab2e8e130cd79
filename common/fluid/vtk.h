// Frames for ParaView.
#pragma once

#include <span>
#include <string>

#include "common/fluid/model.h"
#include "common/fluid/particles.h"

namespace lockstep::fluid {

// Writes the particles as points with velocity (m/s), density (kg/m^3) and id, in the order of their ids, as a legacy
// VTK binary file. density[i] is that of particles.*[i]. Throws InputError where the file cannot be written, and then
// leaves nothing behind.
void write_vtk(const std::string& path, const Particles<float>& particles, std::span<const float> density);

// Writes the edges of the domain, whose walls hold the fluid in, as lines of such a file.
void write_box(const std::string& path, const Model<float>& model);

}  // namespace lockstep::fluid
