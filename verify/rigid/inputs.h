// Scenes of rigid bodies as inputs of their kernels.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/rigid/arrays.h"
#include "common/rigid/scene.h"
#include "common/rigid/step.h"
#include "verify/arrays.h"
#include "verify/kernel.h"

namespace lockstep::verify {

rigid::StepSettings settings_of(const rigid::Scene& scene);

namespace rigid_inputs {

// A scene after as many steps as it says (`settle`), so that bodies touch.
struct Inputs {
  rigid::Scene scene;
  rigid::World<float> world;      // settled
  rigid::StepMemory<float> last;  // of the step before
  rigid::StepMemory<float> now;   // of the step to come: what each of its phases finds, and its contacts in blocks
  rigid::StepSettings settings;

  rigid::Placed<float> placed() const {
    return {world.colliders, world.hulls, {now.placed.data(), static_cast<std::size_t>(world.colliders.count)}};
  }
  std::span<const std::int32_t> group() const {
    return {world.colliders.group.data(), static_cast<std::size_t>(world.colliders.count)};
  }
  std::span<const std::int32_t> body() const {
    return {world.colliders.body.data(), static_cast<std::size_t>(world.colliders.count)};
  }
  float margin() const { return static_cast<float>(settings.margin); }
};

// The inputs of a scene, made by the step in batches. All kernels share them.
std::shared_ptr<const Inputs> inputs(const std::string& path);

// The impulses that the step to come starts with: those of the step before, at the contacts that are still there.
Array<rigid::Impulses<float>> warm_start(const Inputs& in);

// What the step before leaves where contacts are kept: it found them all anew.
void find_kept(const Inputs& in, rigid::NarrowPhaseState& state, rigid::KeptContacts<float>& kept);

// Counts for the work of a kernel.
inline constexpr double bytes_of_box = 24, bytes_of_pose = 32, bytes_of_manifold = sizeof(rigid::Manifold<float>);
double rows_of(const Inputs& in);  // of the solver in a step: one a point in a biased sweep, three in a relaxing one

// The scenes of nearly every kernel. `bench` names scenes to time, `tsan` scenes for the thread sanitizer.
Scenes scenes_of_all(std::vector<std::string> bench, std::vector<std::string> tsan = {"box_pit_4000"});
Scenes and_more(Scenes scenes, const std::string& name);  // added by FULL=1
// The same, and always one in which hulls rest, so that their contacts are kept.
Scenes with_hulls_at_rest(std::vector<std::string> bench, std::vector<std::string> tsan = {"hull_pit_2000"});
inline const std::vector<std::string> of_many_bodies = {"castle", "boxes_100k"},
                                      of_boxes = {"pyramid_24", "box_pit_4000"},
                                      of_hulls = {"hull_soup", "hull_pit_2000"},
                                      settled = {"pyramid_24", "box_pit_4000", "hull_pit_2000"},
                                      and_castle = {"pyramid_24", "box_pit_4000", "hull_pit_2000", "castle_hit"};

}  // namespace rigid_inputs
}  // namespace lockstep::verify
