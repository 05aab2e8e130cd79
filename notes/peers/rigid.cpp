#include "notes/peers/rigid.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>

#include "common/rigid/narrow_phase.h"
#include "common/rigid/place_colliders.h"
#include "common/rigid/step.h"
#include "common/rotation.h"
#include "verify/held_team.h"
#include "verify/rigid/inputs.h"

namespace lockstep::peers {
namespace {

using namespace rigid;

constexpr int warm_steps = 30, steps_of_a_turn = 2;

struct Settled {
  Scene scene;
  StepSettings settings;
  World<float> world;
  StepMemory<float> memory;
};

// By the openmp step, whose bits are those of the serial one.
Settled settle(const std::string& path, int threads) {
  Settled settled{load_scene(path), {}, {}, {}};
  settled.settings = verify::settings_of(settled.scene);
  settled.world = settled.scene.world;
  verify::hold_team(threads, [&] {
    for (int step = 0; step < settled.scene.settle; ++step)
      openmp::step_batches(settled.settings, settled.world, settled.memory);
  });
  return settled;
}

// The collider of each body, which has one.
std::vector<int> collider_of_body(const World<float>& world) {
  std::vector<int> collider(world.bodies.count, -1);
  for (int c = 0; c < world.colliders.count; ++c) {
    int& of_body = collider[world.colliders.body[c]];
    if (of_body >= 0) throw std::runtime_error("a body has several colliders: this comparison is for boxes and planes");
    of_body = c;
  }
  return collider;
}

// The box of each body but the grounds; which body it is, is in `body`.
Boxes boxes_of(const Settled& settled, std::vector<int>& body) {
  const World<float>& world = settled.world;
  Boxes boxes{.boxes = {},
              .grounds = {},
              .friction = world.bodies.friction[0],
              .restitution = world.bodies.restitution[0],
              .gravity = settled.settings.solver.gravity,
              .time_step = settled.settings.solver.time_step,
              .iterations = settled.settings.solver.substeps};
  Array<Pose<float>> placed;
  Bounds<float> bounds;
  serial::place_colliders(world, 0.f, placed, bounds);
  const std::vector<int> collider = collider_of_body(world);
  for (int b = 0; b < world.bodies.count; ++b) {
    const int c = collider[b];
    if (c < 0) throw std::runtime_error("a body has no collider: this comparison is for boxes and planes");
    if (world.bodies.friction[b] != boxes.friction || world.bodies.restitution[b] != boxes.restitution)
      throw std::runtime_error("bodies have several surfaces: this comparison is for one");
    const Pose<float>& pose = placed[c];
    const float inverse = world.bodies.inverse_mass[b].w;
    switch (static_cast<Kind>(world.colliders.kind[c])) {
      case Kind::box:
        boxes.boxes.push_back(
            {pose, world.bodies.motion[b], vector_of(world.colliders.size[c]), inverse > 0 ? 1 / inverse : 0});
        body.push_back(b);
        break;
      case Kind::plane: {
        const Vector3<float> normal = matrix_of(pose.orientation) * Vector3<float>{0, 1, 0};
        boxes.grounds.push_back({normal, dot(normal, pose.position)});
        break;
      }
      default: throw std::runtime_error("this comparison is for boxes and planes");
    }
  }
  return boxes;
}

// How far apart, how fast and how deep bodies are.
Json quality(const Settled& settled, const World<float>& world, double margin) {
  Array<Pose<float>> placed;
  Bounds<float> bounds;
  openmp::place_colliders(world, static_cast<float>(margin / 2), placed, bounds);
  Tree<float> tree;
  Pairs bounded, with_planes, pairs;
  const Colliders<float>& colliders = world.colliders;
  const std::span group(colliders.group.data(), colliders.count);
  spatial::openmp::bvh_build(bounds, tree);
  openmp::bvh_pairs(tree, bounds, group, bounded);
  const std::span<const Pose<float>> poses(placed.data(), colliders.count);
  openmp::plane_pairs(colliders, poses, bounds, with_planes);
  std::ranges::merge(bounded, with_planes, std::back_inserter(pairs));
  NarrowPhaseState state;
  Array<Manifold<float>> manifolds;
  openmp::narrow_phase({colliders, world.hulls, poses}, pairs, static_cast<float>(margin), state, manifolds);
  double deepest = 0, energy = 0, moved = 0, moving = 0;
  for (const Manifold<float>& m : manifolds)
    for (int k = 0; k < m.count; ++k) deepest = std::max(deepest, -double(m.point[k].separation));
  for (int b = 0; b < world.bodies.count; ++b) {
    const Quad<float>& inverse = world.bodies.inverse_mass[b];
    if (!(inverse.w > 0)) continue;
    const Motion<float>& motion = world.bodies.motion[b];
    const Vector3<float> w =
        transposed_times(matrix_of(world.bodies.pose[b].orientation), motion.angular_velocity);
    energy += .5 * dot(motion.velocity, motion.velocity) / inverse.w +
              .5 * (w.x * w.x / inverse.x + w.y * w.y / inverse.y + w.z * w.z / inverse.z);
    const Vector3<float> way = world.bodies.pose[b].position - settled.world.bodies.pose[b].position;
    moved += std::sqrt(dot(way, way)), ++moving;
  }
  return {{"touching_pairs", manifolds.size()},
          {"deepest_mm", 1e3 * deepest},
          {"energy_j_a_body", energy / moving},
          {"moved_mm", 1e3 * moved / moving}};
}

// Our world with the bodies where the engine has them.
World<float> taken_from(const Engine& engine, const Settled& settled, const std::vector<int>& body) {
  World<float> world = settled.world;
  const std::vector<int> collider = collider_of_body(world);
  for (std::size_t k = 0; k < body.size(); ++k) {
    const int b = body[k];
    if (!(world.bodies.inverse_mass[b].w > 0)) continue;
    const BoxBody now = engine.box(k);
    const Pose<float>& local = world.colliders.local[collider[b]];
    Pose<float>& pose = world.bodies.pose[b];
    pose.orientation = now.pose.orientation * conjugate(local.orientation);
    pose.position = now.pose.position - matrix_of(pose.orientation) * local.position;
    world.bodies.motion[b] = now.motion;
  }
  return world;
}

}  // namespace

void compare_engines(Json& rows, const Asked& asked, const MakeEngine& make, const std::string& not_the_same) {
  for (const std::string& name : asked.scenes) {
    const std::string path = path_of("rigid", name);
    const Settled settled = settle(path, std::ranges::max(asked.threads));
    std::vector<int> body;
    const Boxes boxes = boxes_of(settled, body);
    for (const int threads : asked.threads) {
      const std::unique_ptr<Engine> engine = make(boxes, threads);
      World<float> world = settled.world;
      StepMemory<float> memory = settled.memory;
      const auto our_steps = [&](int count) {
        for (int step = 0; step < count; ++step) openmp::step_batches(settled.settings, world, memory);
      };
      for (int step = 0; step < warm_steps; ++step) engine->step();
      verify::hold_team(threads, [&] { our_steps(warm_steps); });
      Json row = {{"work", "a step of rigid bodies"},
                  {"scene", std::filesystem::path(path).stem().string()},
                  {"ours", "rigid/step batches"},
                  {"items", {{"bodies", boxes.boxes.size()}}}};
      row.update(take_turns(
          threads, steps_of_a_turn,
          {[] {}, [&] { for (int step = 0; step < steps_of_a_turn; ++step) engine->step(); }},
          {[] {}, [&] { our_steps(steps_of_a_turn); }}));
      row["quality"] = quality(settled, taken_from(*engine, settled, body), settled.settings.margin);
      row["ours_quality"] = quality(settled, world, settled.settings.margin);
      row["not_the_same"] = not_the_same;
      rows.push_back(row);
    }
  }
}

}  // namespace lockstep::peers
