// Scenes of the game fluid: what a run simulates, and what must hold of it. scenes/README.md has every key of the TOML,
// scenes/fluid/ examples.
#pragma once

#include <optional>
#include <string>

#include "common/fluid/model.h"
#include "common/fluid/particles.h"

namespace lockstep::fluid {

// What must hold of a run beyond staying finite, which every run must.
struct Holds {
  bool momentum_conserved = false;  // to rounding, in every frame
  bool inside_domain = false;       // every particle, after every frame
  // Of the particles inside the block, in the first frame: the analytic sum over the lattice.
  bool lattice_density = false;
  // After this frame, kinetic plus gravitational energy falls from each 200 frames' peak to the next. It need not fall
  // in every frame: the fluid bounces, and trades energy with its compression.
  std::optional<int> energy_falls_after;
};

struct Scene {
  std::string name;  // the file's, without folder and extension
  std::string path;
  Model<double> model;  // convert<float>(model) is what float kernels take
  Particles<float> particles;
  int frames;
  Holds holds;
};

// Reads a TOML scene, or a .fluid file as a scene of one frame. Throws InputError in one line, `file:line:column: what
// was expected` for TOML, where the file cannot be read, is not what scenes/README.md says (an unknown key, a wrong
// type, a number out of range or not finite, a block without a particle) or does not fit the machine's memory, asked
// before particles are made.
Scene load_scene(const std::string& path);

}  // namespace lockstep::fluid
