// Scenes of rigid bodies. scenes/README.md has every key of the TOML, scenes/rigid/ examples.
#pragma once

#include <string>

#include "common/rigid/world.h"

namespace lockstep::rigid {

struct Scene {
  std::string name;  // the file's, without folder and extension
  std::string path;
  World<float> world;
  double time_step;         // s
  Vector3<double> gravity;  // m/s^2
  // Substeps of the solver; frames of `run`, and steps before them; steps before `verify` and `bench` look at a kernel.
  int iterations, frames, rest, settle;
};

// Bytes to make so many bodies of one collider, or triangles, in double and keep them in float, too.
double making_bytes(double bodies, double triangles);

// Reads a TOML scene. Throws InputError in one line, `file:line:column: what was expected`, where the file cannot be
// read, is not what scenes/README.md says (an unknown key, a wrong type, a number out of range or not finite, points
// that have no hull), or does not fit the machine's memory, asked before bodies are made; likewise where a mesh is
// refused (common/mesh_file.h), or a mesh is not closed (common/mesh.h).
Scene load_scene(const std::string& path);

}  // namespace lockstep::rigid
