// Whole steps of rigid bodies, on the scenes of the repository: what stands keeps standing, what slides slides as it
// must, nothing gets lost. Run from the root of the repository, as `make test` does.
#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "common/rigid/make.h"
#include "common/rigid/scene.h"
#include "common/rigid/step.h"
#include "verify/rigid/run.h"

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
  double speed(int body) const {
    return std::sqrt(dot(world.bodies.motion[body].velocity, world.bodies.motion[body].velocity));
  }
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
  double kinetic_energy() const { return verify::energy(world.bodies, {0, 0, 0}) / world.bodies.count; }  // J a body
  bool finite() const {
    for (int i = 0; i < world.bodies.count; ++i) {
      const auto& [p, q, unused] = world.bodies.pose[i];
      const Motion<float>& m = world.bodies.motion[i];
      for (const float x : {p.x, p.y, p.z, q.x, q.y, q.z, q.w, m.velocity.x, m.velocity.y, m.velocity.z,
                            m.angular_velocity.x, m.angular_velocity.y, m.angular_velocity.z})
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

// With a damping ratio of 10, as in shorter substeps, and earliest batches it breathes: .003 J a body.
TEST(RigidStep, PyramidComesToRestInFourSubsteps) {
  SceneRun run("pyramid_24_at_4");
  run.steps(600);
  std::printf("  pyramid_24_at_4: %.2g J a body, deepest %.2f mm\n", run.kinetic_energy(), 1e3 * run.deepest());
  EXPECT_LT(run.kinetic_energy(), 5e-7);
  EXPECT_LT(run.deepest(), .002);
  for (int body = 1; body < run.world.bodies.count; ++body) EXPECT_LT(run.gone(body), .05) << body;
}

// The last brick of the top course has its centre beyond the edge of what it stands on (.51 m along, on a brick that
// ends at .5), and falls.
TEST(RigidStep, WallOneBrickThickStands) {
  SceneRun run("wall");
  run.steps(600);
  const int last = run.world.bodies.count - 1;
  for (int body = 1; body < last; ++body) EXPECT_LT(run.gone(body), .05) << body;
  std::printf("  wall: deepest %.2f mm, brick in the middle %.1f mm off\n", 1e3 * run.deepest(),
              1e3 * run.gone(last / 2));
  EXPECT_LT(run.deepest(), .005);
}

// Ten thousand bricks, each on two to four others: what touches, and what the solver gets. Those that touch are counted
// at rest, as in the first steps some bounce.
TEST(RigidStep, CastleStandsOnAHundredThousandPoints) {
  SceneRun run("castle");
  std::size_t peak = 0;
  for (int i = 0; i < 60; ++i) {
    run.steps(1);
    peak = std::max<std::size_t>(peak, run.points());
  }
  int pairs = 0, points = 0;
  for (const Manifold<float>& m : run.memory.manifolds) {
    const auto touches =
        std::count_if(m.point, m.point + m.count, [](const auto& point) { return point.separation <= 0; });
    pairs += touches > 0, points += static_cast<int>(touches);
  }
  std::printf("  castle: %zu points at the most; %d pairs touch, in %d points; deepest %.2f mm\n", peak, pairs, points,
              1e3 * run.deepest());
  EXPECT_GT(peak, 119'000u);
  EXPECT_GT(points, 100'000);
  EXPECT_EQ(pairs, 25'824);
  EXPECT_LT(run.deepest(), .005);
  for (int body = 1; body < run.world.bodies.count; ++body) EXPECT_LT(run.gone(body), .06) << body;
}

// A body of 2 kg, 3 m up, with inertia about its axes as a box has, turned by a quarter about z: m v^2 / 2 + w I w / 2
// + m g h.
TEST(RigidStep, EnergyIsWhatItIs) {
  World<double> world = make_world();
  begin_body(world, no_offset);
  add_plane(world);
  finish_body(world, immovable);
  const double half_turn = std::sqrt(.5);
  Motion<double> motion{};
  motion.velocity = {1, -2, 2};
  motion.angular_velocity = {0, 4, 0};  // about the body's own x
  begin_body(world, {{7, 3, -5}, {0, 0, half_turn, half_turn}, 0}, motion);
  add_box(world, {.5, 1, 1.5});
  finish_body(world, of_mass(2));
  const double inertia = 2. / 3 * (1 * 1 + 1.5 * 1.5), expected = .5 * 2 * 9 + .5 * inertia * 16 + 2 * 9.81 * 3;
  // Of the float state alone, whose numbers are off by a rounding each, in products of three.
  EXPECT_NEAR(verify::energy(convert<float>(world).bodies, {0, -9.81, 0}), expected, 8 * 0x1p-24 * expected);
}

// A falling ball, an ulp higher or lower: its energy is off by the weight times an ulp of its height, and not by ulps
// to the side. Where bodies meet, what an ulp does grows, and is never forgotten again.
TEST(RigidStep, EnergyForgottenIsWhatUlpsDo) {
  Scene scene = load_scene("scenes/rigid/billiard.toml");
  const verify::RigidRun rack = verify::run_rigid(scene, serial::step_batches, 60);
  const std::vector<double> forgotten = verify::energy_forgotten(scene, serial::step_batches, rack);
  ASSERT_EQ(forgotten.size(), rack.frames.size());
  EXPECT_TRUE(std::ranges::is_sorted(forgotten));
  EXPECT_GT(forgotten.back(), forgotten.front());

  World<double> world = make_world();
  begin_body(world, {{0, 3, 0}, no_rotation, 0});
  add_sphere(world, .5);
  finish_body(world, of_mass(2));
  scene.world = convert<float>(world);
  const verify::RigidRun fall = verify::run_rigid(scene, serial::step_batches, 1);
  EXPECT_NEAR(verify::energy_forgotten(scene, serial::step_batches, fall)[0], 2 * 9.81 * 0x1p-22, 1e-12);
}

// A cube slides down a slope of 20 degrees at g (sin - mu cos) if mu < tan, else it stays. The first steps are left
// out: a contact's normal impulse, and with it friction, takes some substeps to build up, as it starts soft and from
// nothing.
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
    std::printf("  slope, friction %.2f: %.4f m/s^2 of %.4f\n", mus[k],
                (run.speed(1 + k) - before[k]) / (steps * run.scene.time_step), a);
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

// Without gravity's torque about its tip friction and gravity turn the top slowly about the vertical; its spin stays.
// It stands on its tip after 2 s, which without spin it would leave in a tenth of that.
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
      EXPECT_EQ(std::memcmp(run.world.bodies.pose.data(), expected.world.bodies.pose.data(), n * sizeof(Pose<float>)),
                0)
          << name << threads;
      EXPECT_EQ(
          std::memcmp(run.world.bodies.motion.data(), expected.world.bodies.motion.data(), n * sizeof(Motion<float>)),
          0)
          << name << threads;
    }
  }
}

}  // namespace
}  // namespace lockstep::rigid
