// Scenes of the production fluid. scenes/README.md has every key of the TOML, scenes/production_fluid/ examples.
#pragma once

#include <string>

#include "common/production_fluid/liquid.h"

namespace lockstep::production_fluid {

struct Scene {
  std::string name;  // the file's, without folder and extension
  std::string path;
  Fluid<float> fluid;
  Model model;
  int frames = 0;           // to run unless told otherwise
  double volume_bound = 1;  // the largest error of the volume that is allowed, as a share of what it should be
};

// Reads a TOML scene. Throws InputError in one line, `file:line:column: what was expected`, where the file cannot be
// read, is not what scenes/README.md says (an unknown key, a wrong type, a number out of range or not finite, no
// liquid and no source), or does not fit the machine's memory, asked before the fields are made; likewise where a
// mesh is refused (common/mesh_file.h) or is not closed (common/mesh.h).
Scene load_scene(const std::string& path);

}  // namespace lockstep::production_fluid
