// Scenes: what a run simulates, and what must hold of it.
//
// A TOML scene of the game fluid (scenes/fluid/ has examples):
//
//   kind = "fluid"               # required
//   particles_per_metre = 204    # required: the resolution of the fluid at rest, along an axis
//   frames = 100                 # how many to run unless told otherwise, >= 1
//   walls = true                 # whether the faces of the domain hold the fluid in
//   gravity = [0, -9.8, 0]       # m/s^2
//   seed = 1                     # of the jitter, >= 0
//
//   [[block]]                    # one or more: particles on a simple cubic lattice
//   min = [-.065, -.08, -.065]   # m, required; the first particle stands half a spacing from it
//   max = [0, .068, .065]        # m, required, beyond min on every axis; may lie outside the domain, as may min
//   spacing = .005               # m; 1 / particles_per_metre by default
//   jitter = .05                 # 0 .. 1: each particle is moved at random within a cube of this many spacings
//   velocity = [0, 0, 0]         # m/s
//
//   [holds]                      # what the verifier checks, all optional
//   momentum_conserved = true
//   inside_domain = true
//   lattice_density = true
//   energy_falls_after = 400
//
// All else is as in make_model. Particles are numbered block by block, along x first, then y, then z.
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
// was expected` for TOML, where the file cannot be read, is not what is written above (an unknown key, a wrong type, a
// number out of range or not finite, a block without a particle) or does not fit the machine's memory, asked before
// particles are made.
Scene load_scene(const std::string& path);

}  // namespace lockstep::fluid
