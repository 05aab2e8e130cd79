// How fast bricks leave when the ball of castle_hit strikes (notes/contact_solver.md has the table that this prints).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/rigid/scene.h"
#include "common/rigid/step.h"
#include "verify/rigid/run.h"

namespace lockstep::rigid {
namespace {

float speed(const Motion<float>& motion) { return std::sqrt(dot(motion.velocity, motion.velocity)); }

struct Struck {
  float ball, brick;  // m/s: the ball before it strikes, and the fastest brick in the first four steps
  bool energy_falls;  // in each step
};

Struck strike(double push, int relax_sweeps) {
  const Scene scene = load_scene("scenes/rigid/castle_hit.toml");
  StepSettings settings = verify::settings_of(scene);
  settings.solver.max_bias_velocity = push;
  settings.solver.relax_sweeps = relax_sweeps;
  World<float> world = scene.world;
  const auto ball = std::ranges::max_element(world.bodies.motion, {}, speed) - world.bodies.motion.begin();
  Struck struck = {speed(world.bodies.motion[ball]), 0, true};
  StepMemory<float> memory;
  for (int step = 0; step < 4; ++step) {
    const double before = verify::energy(world.bodies, settings.solver.gravity);
    openmp::step_batches(settings, world, memory);
    struck.energy_falls &= verify::energy(world.bodies, settings.solver.gravity) < before;
    for (int body = 0; body < world.bodies.count; ++body)
      if (body != ball) struck.brick = std::max(struck.brick, speed(world.bodies.motion[body]));
  }
  std::printf("  push %.0f m/s, %2d relaxing sweeps: fastest brick %.1f m/s, ball %.1f\n", push, relax_sweeps,
              struck.brick, struck.ball);
  return struck;
}

// Without restitution the solved equations let no brick leave faster than the ball came. What is faster by default is
// the push and sweeps that are too few; no step gains energy by it.
TEST(CastleHit, NoBrickIsFasterThanTheBallOnceSolved) {
  const Struck solved = strike(0, 20);
  EXPECT_LE(solved.brick, solved.ball);
  for (const auto& [push, sweeps] : {std::pair(3., 1), {0., 1}, {3., 20}}) EXPECT_TRUE(strike(push, sweeps).energy_falls);
  EXPECT_TRUE(solved.energy_falls);
}

}  // namespace
}  // namespace lockstep::rigid
