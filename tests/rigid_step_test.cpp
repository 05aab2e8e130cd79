// Whole steps of rigid bodies, on the scenes of the repository: what stands keeps standing, what slides slides as it must, nothing gets
// lost. Run from the root of the repository, as `make test` does.
#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "common/rigid/make.h"
#include "common/rigid/scene.h"
#include "common/rigid/step.h"
#include "verify/rigid_run.h"

namespace lockstep::rigid {
namespace {

struct SceneRun {
  Scene scene;
  World<float> world;
  StepMemory<float> memory;
  StepSettings settings;

  explicit SceneRun(const std::string& name)
      : scene(load_scene("scenes/rigid/" + name + ".toml")), world(scene.world), settings(verify::settings_of(scene)) {
    omp_set_num_threads(1);  // the results are the same, and a thread that waits for a busy core waits long
  }
  void steps(int n) {
    for (int i = 0; i < n; ++i) openmp::step_batches(settings, world, memory);
  }
  double gone(int body) const {  // m, from where it was at the start
    const Vector3<float> off = world.bodies.pose[body].position - scene.world.bodies.pose[body].position;
    return std::sqrt(dot(off, off));
  }
  double speed(int body) const { return std::sqrt(dot(world.bodies.motion[body].velocity, world.bodies.motion[body].velocity)); }
  double deepest() const {  // m
    double depth = 0;
    for (const Manifold<float>& m : memory.manifolds)
      for (int k = 0; k < m.count; ++k) depth = std::max(depth, -double(m.point[k].separation));
    return depth;
  }
  int points() const {
    int points = 0;
    for (const Manifold<float>& m : memory.manifolds) points += m.count;
    return points;
  }
  bool finite() const {
    for (int i = 0; i < world.bodies.count; ++i) {
      const auto& [p, q, unused] = world.bodies.pose[i];
      const Motion<float>& m = world.bodies.motion[i];
      for (const float x : {p.x, p.y, p.z, q.x, q.y, q.z, q.w, m.velocity.x, m.velocity.y, m.velocity.z, m.angular_velocity.x,
                            m.angular_velocity.y, m.angular_velocity.z})
        if (!std::isfinite(x)) return false;
    }
    return true;
  }
};

TEST(RigidStep, StackOfTenStandsForAMinute) {
  SceneRun run("stack_10");
  run.steps(3600);
  for (int body = 1; body < run.world.bodies.count; ++body) {
    EXPECT_LT(run.gone(body), .02) << body;
    EXPECT_LT(run.speed(body), 1e-3) << body;
  }
  EXPECT_LT(run.deepest(), .002);
}

// Others count 17,872 touching pairs in it, and four points each.
TEST(RigidStep, PyramidStandsForTenSeconds) {
  SceneRun run("pyramid_24");
  double deepest = 0;
  for (int i = 0; i < 600; ++i) {
    run.steps(1);
    deepest = std::max(deepest, run.deepest());
  }
  EXPECT_EQ(run.memory.manifolds.size(), 17872u);
  EXPECT_EQ(run.points(), 71488);
  std::printf("  pyramid_24: deepest in 600 steps %.2f mm, at the end %.2f mm\n", 1e3 * deepest, 1e3 * run.deepest());
  EXPECT_LT(run.deepest(), .002);
  for (int body = 1; body < run.world.bodies.count; ++body) EXPECT_LT(run.gone(body), .05) << body;
}

// The last brick of the top course has its centre beyond the edge of what it stands on (.51 m along, on a brick that ends at .5), and
// falls.
TEST(RigidStep, WallOneBrickThickStands) {
  SceneRun run("wall");
  run.steps(600);
  const int last = run.world.bodies.count - 1;
  for (int body = 1; body < last; ++body) EXPECT_LT(run.gone(body), .05) << body;
  std::printf("  wall: deepest %.2f mm, brick in the middle %.1f mm off\n", 1e3 * run.deepest(), 1e3 * run.gone(last / 2));
  EXPECT_LT(run.deepest(), .005);
}

// A cube slides down a slope of 20 degrees at g (sin - mu cos) if mu < tan, else it stays. The first steps are left out: a contact's normal
// impulse, and with it friction, takes some substeps to build up, as it starts soft and from nothing.
TEST(RigidStep, SlopeHoldsBelowTheFrictionAngleAlone) {
  SceneRun run("slope");
  const double angle = 20 * std::acos(-1.) / 180, g = 9.81, mus[] = {0, .2, .3, .43, .6};
  run.steps(20);
  double before[5];
  for (int k = 0; k < 5; ++k) before[k] = run.speed(1 + k);
  const int steps = 60;
  run.steps(steps);
  for (int k = 0; k < 5; ++k) {
    const double a = mus[k] < std::tan(angle) ? g * (std::sin(angle) - mus[k] * std::cos(angle)) : 0;
    const double gained = a * steps * run.scene.time_step;
    EXPECT_NEAR(run.speed(1 + k) - before[k], gained, .002 * gained + 1e-4) << mus[k];
    std::printf("  slope, friction %.2f: %.4f m/s^2 of %.4f\n", mus[k], (run.speed(1 + k) - before[k]) / (steps * run.scene.time_step), a);
  }
}

// A point on the other side of a plane is inside it, however fast it came.
TEST(RigidStep, NothingTunnelsThroughTheGround) {
  World<double> world = make_world();
  begin_body(world, no_offset);
  add_plane(world);
  finish_body(world, immovable);
  for (int k = 0; k < 40; ++k) {
    Motion<double> motion{};
    motion.velocity = {0, -5. * k * k, 0};
    begin_body(world, {{3. * k, 5, 0}, no_rotation, 0}, motion);
    if (k % 2)
      add_sphere(world, .1);
    else
      add_box(world, {.1, .2, .1});
    finish_body(world, of_mass(1));
  }
  World<float> bodies = convert<float>(world);
  StepSettings settings;
  settings.solver.time_step = 1 / 60.;
  settings.solver.gravity = {0, -9.81, 0};
  StepMemory<float> memory;
  for (int i = 0; i < 3000; ++i) openmp::step_batches(settings, bodies, memory);
  for (int body = 1; body < bodies.bodies.count; ++body) EXPECT_GT(bodies.bodies.pose[body].position.y, .09) << body;
}

// Without gravity's torque about its tip friction and gravity turn the top slowly about the vertical; its spin stays. It stands on its tip
// after 2 s, which without spin it would leave in a tenth of that.
TEST(RigidStep, TopStaysUp) {
  SceneRun run("top");
  run.steps(1000);
  EXPECT_TRUE(run.finite());
  EXPECT_GT(run.world.bodies.pose[1].position.y, .035);
}

// The balls of a rack, struck: momentum along the table is what the cue ball brought, less what friction took.
TEST(RigidStep, RackIsBroken) {
  SceneRun run("billiard");
  run.steps(100);
  double along = 0;
  int moving = 0;
  for (int body = 1; body < run.world.bodies.count; ++body) {
    along += .17 * run.world.bodies.motion[body].velocity.x;
    moving += run.speed(body) > .05;
  }
  EXPECT_LE(along, .17 * 5 * (1 + 1e-5));
  EXPECT_GT(along, .5 * .17 * 5);
  EXPECT_GT(moving, 10);
}

TEST(RigidStep, SerialAndParallelStepsHaveTheSameBits) {
  for (const std::string name : {"pyramid_15", "mesh_and_hulls", "degenerate"}) {
    SceneRun expected(name);
    for (int i = 0; i < 20; ++i) serial::step_batches(expected.settings, expected.world, expected.memory);
    for (const int threads : {1, 2, 3, 5}) {
      SceneRun run(name);
      omp_set_num_threads(threads);
      run.steps(20);
      const int n = run.world.bodies.count;
      EXPECT_EQ(std::memcmp(run.world.bodies.pose.data(), expected.world.bodies.pose.data(), n * sizeof(Pose<float>)), 0)
          << name << threads;
      EXPECT_EQ(std::memcmp(run.world.bodies.motion.data(), expected.world.bodies.motion.data(), n * sizeof(Motion<float>)), 0)
          << name << threads;
    }
  }
}

}  // namespace
}  // namespace lockstep::rigid
