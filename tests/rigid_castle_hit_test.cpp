// How fast bricks leave when the ball of castle_hit strikes, and what energy position correction adds
// (notes/contact_solver.md has the tables that this prints).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <string>

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
  settings.solver.substeps = 10;
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
  for (const auto& [push, sweeps] : {std::pair(3., 1), {0., 1}, {3., 20}})
    EXPECT_TRUE(strike(push, sweeps).energy_falls);
  EXPECT_TRUE(solved.energy_falls);
}

// Bodies that overlap at rest are pushed apart at max_bias_velocity at most. The push adds no more energy in a step
// than bodies have that all leave at that speed against gravity.
TEST(PositionCorrection, AddsNoMoreEnergyThanItsOwnSpeed) {
  for (const std::string name : {"castle", "soup_10", "degenerate", "four_bodies", "pyramid_15"}) {
    const Scene scene = load_scene("scenes/rigid/" + name + ".toml");
    const SolverSettings solver = verify::settings_of(scene).solver;
    const double v = solver.max_bias_velocity, g = std::sqrt(dot(scene.gravity, scene.gravity));
    double bound = 0;
    for (const auto& inverse : scene.world.bodies.inverse_mass)
      if (inverse.w > 0) bound += (.5 * v * v + g * v * solver.time_step) / inverse.w;
    const auto energies = verify::energy_of_push(scene, openmp::step_batches, 20);
    const double most = *std::ranges::max_element(energies);
    std::printf("  %s: push adds at most %.2g J in a step, %.2g J in twenty, bound %.2g J a step\n", name.c_str(), most,
                std::accumulate(energies.begin(), energies.end(), 0.), bound);
    EXPECT_LE(most, bound) << name;
  }
}

// While the ball strikes (steps 2 to 6), the push takes energy away: bodies that part need less of an impulse.
TEST(PositionCorrection, TakesEnergyFromTheBlow) {
  const auto energies = verify::energy_of_push(load_scene("scenes/rigid/castle_hit.toml"), openmp::step_batches, 6);
  for (const double energy : energies) {
    std::printf("  push %.3g J\n", energy);
    EXPECT_LT(energy, 0);
  }
}

}  // namespace
}  // namespace lockstep::rigid
