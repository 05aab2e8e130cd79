// Scenes of the production face. scenes/README.md has every key of the TOML, scenes/production_face/ examples.
#pragma once

#include <string>

#include "common/production_face/body.h"
#include "common/production_face/flesh_material.h"
#include "common/production_face/motion.h"

namespace lockstep::production_face {

struct Scene {
  std::string name;  // the file's, without folder and extension
  std::string path;
  Body<float> body;
  Flesh flesh;
  Pose<float> pose;  // at the start
  Motion motion;
  int frames = 1;
  double tolerance = 1e-3;  // of a frame's forces (step.h)
  int turned = 0;           // tetrahedra of a mesh file that had a negative volume, and now have a positive one
  int doubled = 0;          // nodes of a mesh file that stand where another does
};

// Reads a TOML scene. Throws InputError in one line, `file:line:column: what was expected`, where the file cannot be
// read, is not what scenes/README.md says, or does not fit the machine's memory, asked before the body is made.
Scene load_scene(const std::string& path);

}  // namespace lockstep::production_face
