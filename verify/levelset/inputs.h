// The scenes of the level sets as their kernels find them, and the cases that marching and sweeping share.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/levelset/scene.h"
#include "verify/arrays.h"
#include "verify/kernel.h"

namespace lockstep::verify::levelset_inputs {

struct Inputs {
  levelset::Scene scene;
  levelset::Distances<float> start;  // as the serial initialize leaves them
  float band;
};

// Shared by all kernels.
std::shared_ptr<const Inputs> inputs(const std::string& path);

// Names the point of a distance: "distance of (x, y, z)".
ValueName point_name(const levelset::Field<float>& field);

inline constexpr double flops_of_upwind = 30;

using Change = std::function<void(levelset::Distances<float>&)>;

// A kernel that must leave the bits of `twin`. Its work is counted in points within the band. `best` is null where the
// twin is the best serial form.
Case bitwise_case(std::shared_ptr<const Inputs> in, Change twin, Change best, Change openmp, double flops_a_point);

// Another algorithm for the same discrete equations: within rounding of the distances of `reference`. `what` is added
// to the report's row.
Case same_distances_case(std::shared_ptr<const Inputs> in, Change reference, Change other, const std::string& what);

// How much of their work blocks repeat, in words: they do the work of their padding again.
std::string overlap(const Inputs& in);

// The scenes of every kernel: narrow bands, and, for what runs on undivided grids, full grids too. `bench` are names of
// scenes to time.
Scenes scenes_in_bands(std::vector<std::string> bench);
Scenes scenes_of_all(std::vector<std::string> bench);
Scenes without_tsan(Scenes scenes);  // for forms that run another form's code

}  // namespace lockstep::verify::levelset_inputs
