// Scenes of the level set. scenes/README.md has every key of the TOML, scenes/levelset/ examples.
#pragma once

#include <string>
#include <vector>

#include "common/levelset/field.h"
#include "common/levelset/grid.h"
#include "common/levelset/shapes.h"

namespace lockstep::levelset {

struct Scene {
  std::string name;  // the file's, without folder and extension
  std::string path;
  Grid grid;
  Field<float> phi;           // < 0 inside, else outside; its zero is the interface, and there is one
  double band;                // m; infinite where all points are wanted
  int rounds;                 // >= 1
  std::vector<Shape> shapes;  // whose union is the inside, see signed_distance in shapes.h; empty for a mesh
};

// Reads a TOML scene. Throws InputError in one line, `file:line:column: what was expected`, where the file cannot be
// read, is not what scenes/README.md says (an unknown key, a wrong type, a number out of range or not finite, a band
// wider than the grid), does not fit the machine's memory, asked before the field is made, or no interface comes
// between points of the grid; likewise where a mesh is refused (common/mesh_file.h), is not closed (common/mesh.h) or
// reaches beyond the grid (common/levelset/fit.h).
Scene load_scene(const std::string& path);

}  // namespace lockstep::levelset
