// The scenes of the game fluid as its kernels find them: what the serial float run hands each.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/fluid/fluid.h"
#include "common/fluid/scene.h"
#include "verify/arrays.h"
#include "verify/compare.h"
#include "verify/kernel.h"

namespace lockstep::verify::fluid_inputs {

// A scene in the state after some frames, with the serial answers and the truth.
struct Inputs {
  fluid::Scene scene;
  int frames_before = 0;             // that the serial step made first
  fluid::Particles<float> unsorted;  // rebuild_grid's
  fluid::Fluid<float> fluid;         // sorted, with the density and acceleration that the serial kernels give
  fluid::Fluid<double> truth;        // the same numbers, widened
  std::vector<double> true_density;
  std::vector<double> density_rounding;
  double tested_pairs = 0, near_pairs = 0;  // in neighbouring cells; within h
};

// Shared by all kernels.
std::shared_ptr<const Inputs> inputs(const std::string& path);

// The elements that count, without the padding.
inline std::span<const float> first(const Array<float>& array, int count) { return {array.data(), std::size_t(count)}; }
inline std::span<const double> first(const Array<double>& array, int count) {
  return {array.data(), std::size_t(count)};
}

// Names a particle by its id and place: "density of particle 12 at (...)". `in` must outlive what is returned.
ElementName particle_name(const Inputs& in, const std::string& what);
// The same for the elements of an array: "position.x of particle 12 at (...)".
ValueName particle_value_name(const Inputs& in);

// The scenes of every kernel. `bench` are names of scenes to time.
Scenes scenes_with(std::vector<std::string> bench = {"dam_break_100k"});

inline constexpr double particle_bytes = 10 * 4;  // id, position and two velocities

}  // namespace lockstep::verify::fluid_inputs
