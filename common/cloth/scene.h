// Scenes of the game cloth. scenes/README.md has every key of the TOML, scenes/cloth/ examples.
#pragma once

#include <string>
#include <vector>

#include "common/cloth/cloth.h"

namespace lockstep::cloth {

struct Scene {
  std::string name;  // the file's, without folder and extension
  std::string path;
  Cloth<double> cloth;                // convert<float>(cloth) is what float kernels take
  std::vector<Cloth<double>> others;  // beside it, in the order of the file; cloths do not touch one another
  Bodies<double> bodies;              // without thickness: no particle ends a step inside one, unless it was pinned
  int frames;
};

// Reads a TOML scene. Throws InputError in one line, `file:line:column: what was expected`, where the file cannot be
// read, is not what scenes/README.md says (an unknown key, a wrong type, a number out of range or not finite, a pin
// that is not on the sheet), or does not fit the machine's memory, asked before the cloth is made; likewise where a
// mesh is refused (common/mesh_file.h), or tied particles are at one place. Open meshes, and edges of more than two
// triangles, are taken.
Scene load_scene(const std::string& path);

}  // namespace lockstep::cloth
