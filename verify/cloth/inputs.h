// The scenes of the game cloth as its kernels find them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/cloth/scene.h"
#include "verify/arrays.h"
#include "verify/kernel.h"

namespace lockstep::verify::cloth_inputs {

// A scene in the state after some steps, so that the cloth has left its plane and met what it falls on.
struct Inputs {
  cloth::Scene scene;
  std::shared_ptr<const cloth::Cloth<float>> start;  // as the scene says
  // Within the step after the settling.
  std::shared_ptr<const cloth::Cloth<float>> before_verlet, before_relax, before_collide;
};

// Made by the serial step. Shared by all kernels.
std::shared_ptr<const Inputs> inputs(const std::string& path);

// Names the particle of a sheet by row and column, of a mesh by its number.
ValueName particle_name(const cloth::Cloth<float>& cloth);

// For the work of a kernel: particles that move, and the projections of a relaxation.
double free_particles(const cloth::Cloth<float>& cloth);
double projections(const cloth::Cloth<float>& cloth);
double verlet_flops(const cloth::Cloth<float>& cloth);  // of a substep
inline constexpr double flops_of_projection = 27;

// The scenes of every kernel: sheets, and, for what runs on any cloth, meshes too. `bench` are names of scenes to time.
Scenes scenes_of_sheets(std::vector<std::string> bench);
Scenes scenes_of_all(std::vector<std::string> bench);

// Whether the scene has one cloth; whether it is a sheet, for forms that run on sheets alone.
bool has_one_cloth(const std::string& path);
bool is_sheet(const std::string& path);

}  // namespace lockstep::verify::cloth_inputs
