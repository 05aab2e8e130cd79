// The verifier's checks of runs of the game cloth and of convergence. Each test plants one mistake in a step that is
// right otherwise.
#include <gtest/gtest.h>

#include <cmath>
#include <initializer_list>
#include <limits>
#include <string>
#include <utility>

#include "common/cloth/collide.h"
#include "common/cloth/make.h"
#include "common/cloth/relax.h"
#include "common/cloth/scene.h"
#include "common/cloth/step.h"
#include "common/cloth/verlet.h"
#include "verify/arrays.h"
#include "verify/cloth/run.h"
#include "verify/compare.h"

namespace lockstep::verify {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();

using ClothStep = cloth::Step<float>;
using GameCloth = cloth::Cloth<float>;

// A napkin that falls on a sphere, and from there to the floor.
cloth::Scene napkin(int frames) {
  cloth::Scene scene = cloth::load_scene("scenes/cloth/tiny.toml");
  scene.frames = frames;
  return scene;
}

Judgement judge_run(const cloth::Scene& scene, ClothStep* step) {
  GameCloth expected = cloth::convert<float>(scene.cloth);
  for (int frame = 0; frame < scene.frames; ++frame) cloth::serial::step_chains(expected);
  Judgement judgement{.verdict = Verdict::bitwise, .worst_at = ""};
  check_run(judgement, scene, expected, step);
  return judgement;
}

int middle(const GameCloth& cloth) { return cloth.sheet.index(cloth.sheet.rows / 2, cloth.sheet.columns / 2); }

// A step composed of its parts; correct if `relax` is.
template <class Relax>
void step_by(GameCloth& c, const Relax& relax, bool collide = true) {
  for (int substep = 0; substep < c.model.substeps; ++substep) {
    cloth::serial::verlet(c);
    relax(c);
    if (collide) cloth::serial::collide(c);
  }
}

void cloth_right(GameCloth& c) {
  step_by(c, [](GameCloth& c) { cloth::serial::relax_chains(c, c.model.iterations); });
}

void cloth_frozen(GameCloth&) {}

template <int axis>
void cloth_moved_by_one_ulp(GameCloth& c) {
  cloth::serial::step_chains(c);
  float& x = (axis == 0 ? c.position.x : axis == 1 ? c.position.y : c.position.z)[middle(c)];
  x = std::nextafter(x, inf);
}

void cloth_short_of_one_iteration(GameCloth& c) {
  step_by(c, [](GameCloth& c) { cloth::serial::relax_chains(c, c.model.iterations - 1); });
}

void cloth_in_another_order(GameCloth& c) { cloth::serial::step_colours(c); }

void cloth_without_friction(GameCloth& c) {
  const float friction = std::exchange(c.bodies.friction, 0.f);
  cloth::serial::step_chains(c);
  c.bodies.friction = friction;
}

void cloth_without_bodies(GameCloth& c) {
  step_by(
      c, [](GameCloth& c) { cloth::serial::relax_chains(c, c.model.iterations); }, false);
}

// Half of the thickness is missing: no particle is inside a body, but the bits differ.
void cloth_too_thin(GameCloth& c) {
  GameCloth thin = c;
  for (auto& plane : thin.bodies.planes) plane.offset -= .005f;
  for (auto& capsule : thin.bodies.capsules) capsule.radius -= .005f;
  cloth::serial::step_chains(thin);
  c.position = thin.position, c.previous = thin.previous;
}

void cloth_with_one_in_the_sphere(GameCloth& c) {
  cloth::serial::step_chains(c);
  const Vector3<float>& centre = c.bodies.capsules[0].from;
  const int i = middle(c);
  c.position.x[i] = centre.x, c.position.y[i] = centre.y, c.position.z[i] = centre.z;
}

void cloth_to_nan(GameCloth& c) {
  cloth::serial::step_chains(c);
  c.position.y[middle(c)] = nan;
}

void cloth_to_infinity(GameCloth& c) {
  cloth::serial::step_chains(c);
  c.position.z[middle(c)] = -inf;
}

void cloth_with_a_velocity_of_nan(GameCloth& c) {
  cloth::serial::step_chains(c);
  c.previous.x[middle(c)] = nan;
}

TEST(CheckClothRun, PassesARightStep) {
  const cloth::Scene scene = napkin(100);
  for (ClothStep* step :
       std::initializer_list<ClothStep*>{cloth::serial::step_chains, cloth_right, cloth::openmp::step_chains}) {
    const Judgement judgement = judge_run(scene, step);
    EXPECT_TRUE(judgement.passed) << judgement.worst_at;
    EXPECT_EQ(judgement.error, 0);
  }
}

// After one step, and after a hundred, when the cloth has touched both bodies.
TEST(CheckClothRun, FailsOnOneUlpOfOneParticle) {
  for (const int frames : {1, 100})
    for (ClothStep* step : {cloth_moved_by_one_ulp<0>, cloth_moved_by_one_ulp<1>, cloth_moved_by_one_ulp<2>}) {
      const Judgement judgement = judge_run(napkin(frames), step);
      EXPECT_FALSE(judgement.passed);
      EXPECT_GE(judgement.error, 1);
      EXPECT_EQ(judgement.worst_at.rfind("position.", 0), 0u) << judgement.worst_at;
    }
  const Judgement judgement = judge_run(napkin(1), cloth_moved_by_one_ulp<0>);
  EXPECT_EQ(judgement.error, 1) << "the one that was moved, and no other";
  EXPECT_NE(judgement.worst_at.find("particle " + std::to_string(middle(cloth::convert<float>(napkin(1).cloth))) + ' '),
            std::string::npos)
      << judgement.worst_at;
}

TEST(CheckClothRun, FailsOnEveryWrongStep) {
  struct {
    const char* name;
    ClothStep* step;
  } const wrong[] = {
      {"frozen", cloth_frozen},
      {"one iteration less", cloth_short_of_one_iteration},
      {"another order", cloth_in_another_order},
      {"friction forgotten", cloth_without_friction},
      {"half of the thickness", cloth_too_thin},
  };
  const cloth::Scene scene = napkin(100);
  for (const auto& [name, step] : wrong) {
    const Judgement judgement = judge_run(scene, step);
    EXPECT_FALSE(judgement.passed) << name;
    EXPECT_GE(judgement.error, 1) << name << ": " << judgement.worst_at;
  }
}

TEST(CheckClothRun, SaysWhatBroke) {
  const cloth::Scene scene = napkin(100);
  const std::string particle = "particle " + std::to_string(middle(cloth::convert<float>(scene.cloth)));
  const auto expect = [&](ClothStep* step, const std::string& what) {
    const Judgement judgement = judge_run(scene, step);
    EXPECT_FALSE(judgement.passed);
    EXPECT_EQ(judgement.worst_at, what);
  };
  expect(cloth_to_nan, "position.y of " + particle + " is not finite after step 1");
  expect(cloth_to_infinity, "position.z of " + particle + " is not finite after step 1");
  expect(cloth_with_a_velocity_of_nan, "previous.x of " + particle + " is not finite after step 1");
  expect(cloth_with_one_in_the_sphere, particle + " is 0.080000 m inside a body after step 1");
  const Judgement through = judge_run(scene, cloth_without_bodies);
  EXPECT_FALSE(through.passed);
  EXPECT_NE(through.worst_at.find(" m inside a body after step "), std::string::npos) << through.worst_at;
}

// The last step must be checked as well: no later step would reveal its fault.
TEST(CheckClothRun, LooksAtTheLastStep) {
  const cloth::Scene scene = napkin(1);
  for (ClothStep* step : {cloth_to_nan, cloth_with_one_in_the_sphere}) EXPECT_FALSE(judge_run(scene, step).passed);
}

TEST(ClothFacts, AreSeenToBreak) {
  const cloth::Scene scene = napkin(1);
  const GameCloth whole = cloth::convert<float>(scene.cloth);
  const int i = middle(whole);
  EXPECT_EQ(first_not_finite(whole), "");
  EXPECT_EQ(deepest_inside(scene.bodies, whole).depth, 0);
  for (const float wrong : {nan, inf, -inf})
    for (Array<float> Vectors<float>::*axis : {&Vectors<float>::x, &Vectors<float>::y, &Vectors<float>::z}) {
      GameCloth broken = whole;
      (broken.position.*axis)[i] = wrong;
      EXPECT_NE(first_not_finite(broken), "");
    }

  cloth::Bodies<double> bodies;
  const auto depth_at = [&](float x, float y, float z) {
    GameCloth moved = whole;
    moved.position.x[i] = x, moved.position.y[i] = y, moved.position.z[i] = z;
    const Deepest deepest = deepest_inside(bodies, moved);
    EXPECT_TRUE(deepest.depth == 0 || deepest.particle == i);
    return deepest.depth;
  };
  bodies.planes = {{.normal = {0, 1, 0}, .offset = .25}};  // y < .25
  EXPECT_EQ(depth_at(0, .25f, 0), 0);
  EXPECT_EQ(depth_at(0, -.5f, 0), .75);
  bodies = {};
  bodies.capsules = {{.from = {2, 0, 0}, .to = {4, 0, 0}, .radius = .5}};
  EXPECT_EQ(depth_at(3, .25f, 0), .25);
  EXPECT_EQ(depth_at(4.25f, 0, 0), .25);  // in the cap
  EXPECT_EQ(depth_at(1.75f, 0, 0), .25);
  EXPECT_EQ(depth_at(3, .5f, 0), 0);
  bodies = {};
  bodies.boxes = {
      {.centre = {2, 0, 0}, .half = {.5, .25, 1}, .axis = {{{0, 1, 0}, {0, 0, 1}, {1, 0, 0}}}}};  // turned: 1 along x
  EXPECT_EQ(depth_at(2.5f, 0, 0), .25);
  EXPECT_EQ(depth_at(2.875f, 0, 0), .125);
  EXPECT_EQ(depth_at(2, .375f, 0), .125);
  EXPECT_EQ(depth_at(2, 0, .25f), 0);

  // A pinned particle may be inside a body.
  GameCloth pinned = whole;
  pinned.inverse_mass[i] = 0;
  pinned.position.x[i] = 2;
  EXPECT_EQ(deepest_inside(bodies, pinned).depth, 0);
}

// Converged: the residual of a form after enough iterations, compared with the residual of the original order. Without
// gravity the scene is one relaxation; with gravity it is many steps.
TEST(ResidualLeft, TellsARelaxationThatStalls) {
  constexpr int n = 10;
  const auto half = [](GameCloth& c, int iterations) { cloth::serial::relax_original(c, iterations / 2); };
  const auto none = [](GameCloth&, int) {};
  const auto to_nan = [](GameCloth& c, int iterations) {
    cloth::serial::relax_original(c, iterations);
    c.position.x[middle(c)] = nan;
  };
  for (const char* name : {"pulled_edge", "rope"}) {
    SCOPED_TRACE(name);
    const GameCloth start =
        cloth::convert<float>(cloth::load_scene("scenes/cloth/" + std::string(name) + ".toml").cloth);
    const double target = residual_left(start, cloth::serial::relax_original, n);
    EXPECT_GT(target, 0);
    EXPECT_EQ(residual_left(start, cloth::serial::relax_original, n), target);
    EXPECT_FALSE(residual_left(start, half, n) <= target);
    EXPECT_FALSE(residual_left(start, none, n) <= target);
    EXPECT_FALSE(residual_left(start, to_nan, n) <= target);
  }
}

}  // namespace
}  // namespace lockstep::verify
