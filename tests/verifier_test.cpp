// A verifier that cannot fail is worthless: its comparisons and its checks of whole steps, given what is wrong.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "common/cloth/collide.h"
#include "common/cloth/make.h"
#include "common/cloth/relax.h"
#include "common/cloth/scene.h"
#include "common/cloth/step.h"
#include "common/cloth/verlet.h"
#include "common/fluid/advance.h"
#include "common/fluid/collisions.h"
#include "common/fluid/convert.h"
#include "common/fluid/densities.h"
#include "common/fluid/forces.h"
#include "common/fluid/id_order.h"
#include "common/fluid/rebuild_grid.h"
#include "common/fluid/scene.h"
#include "verify/arrays.h"
#include "verify/cloth/run.h"
#include "verify/compare.h"
#include "verify/fluid/bounds.h"
#include "verify/fluid/run.h"

namespace lockstep::verify {
namespace {

using namespace fluid;

constexpr float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();

std::string element(std::size_t k) { return "element " + std::to_string(k); }

// --- Bitwise

Judgement compare_bits(const std::vector<float>& openmp, const std::vector<float>& serial) {
  Judgement judgement{.verdict = Verdict::bitwise, .worst_at = ""};
  same_bits(judgement, std::span<const float>(openmp), std::span<const float>(serial), element);
  return judgement;
}

float with_bit_flipped(float x, int bit) { return std::bit_cast<float>(std::bit_cast<std::uint32_t>(x) ^ 1u << bit); }

TEST(SameBits, PassesOnTheSame) {
  const Judgement judgement = compare_bits({1, -0.f, nan, inf}, {1, -0.f, nan, inf});
  EXPECT_TRUE(judgement.passed);
  EXPECT_EQ(judgement.error, 0);
  EXPECT_EQ(judgement.worst_at, "");
}

TEST(SameBits, FailsOnAnyOneBit) {
  for (int bit = 0; bit < 32; ++bit) EXPECT_FALSE(compare_bits({1, with_bit_flipped(2, bit)}, {1, 2}).passed) << bit;
}

TEST(SameBits, TellsZerosAndNansApart) {
  EXPECT_FALSE(compare_bits({-0.f}, {0.f}).passed);
  EXPECT_FALSE(compare_bits({nan}, {0}).passed);
  EXPECT_FALSE(compare_bits({0}, {nan}).passed);
  EXPECT_FALSE(compare_bits({with_bit_flipped(nan, 0)}, {nan}).passed);
}

TEST(SameBits, CountsAndNamesTheFirst) {
  const Judgement judgement = compare_bits({1, 2.5, 3, 4.5}, {1, 2, 3, 4});
  EXPECT_EQ(judgement.error, 2);
  EXPECT_EQ(judgement.worst_at, "element 1: openmp 2.5, serial 2");
}

TEST(SameBits, KeepsAnEarlierFailure) {
  Judgement judgement{.verdict = Verdict::bitwise, .worst_at = ""};
  const std::vector<float> right = {1}, wrong = {2};
  same_bits(judgement, std::span<const float>(wrong), std::span<const float>(right), element);
  same_bits(judgement, std::span<const float>(right), std::span<const float>(right), element);
  EXPECT_FALSE(judgement.passed);
}

TEST(HashBytes, TellsOneBitAndOrder) {
  const auto hash = [](const std::vector<float>& values) { return hash_bytes(std::span<const float>(values)); };
  EXPECT_EQ(hash({1, 2}), hash({1, 2}));
  EXPECT_NE(hash({1, 2}), hash({2, 1}));
  EXPECT_NE(hash({0.f}), hash({-0.f}));
  for (int bit = 0; bit < 32; ++bit) EXPECT_NE(hash({1, with_bit_flipped(2, bit)}), hash({1, 2}));
}

// --- Bounded

Judgement compare_bounded(const std::vector<float>& openmp, const std::vector<float>& serial, const std::vector<double>& truth,
                          const std::vector<double>& rounding) {
  Judgement judgement{.verdict = Verdict::bounded, .worst_at = ""};
  within_bound(judgement, openmp, serial, truth, rounding, element);
  return judgement;
}

TEST(WithinBound, PassesOnExactlyTheBoundAndFailsJustAbove) {
  // Twice the serial error, .25, and the rounding, .5: exactly 1.
  EXPECT_TRUE(compare_bounded({5}, {4.25}, {4}, {.5}).passed);
  EXPECT_TRUE(compare_bounded({3}, {4.25}, {4}, {.5}).passed);
  EXPECT_FALSE(compare_bounded({std::nextafter(5.f, 6.f)}, {4.25}, {4}, {.5}).passed);
  EXPECT_FALSE(compare_bounded({std::nextafter(3.f, 2.f)}, {4.25}, {4}, {.5}).passed);
  EXPECT_TRUE(compare_bounded({4}, {4}, {4}, {0}).passed);
  EXPECT_FALSE(compare_bounded({std::nextafter(4.f, 5.f)}, {4}, {4}, {0}).passed);
}

TEST(WithinBound, FailsOnWhatIsNoNumber) {
  EXPECT_FALSE(compare_bounded({nan}, {1}, {1}, {1}).passed);
  EXPECT_FALSE(compare_bounded({1}, {nan}, {1}, {1}).passed);
  EXPECT_FALSE(compare_bounded({1}, {1}, {nan}, {1}).passed);
  EXPECT_FALSE(compare_bounded({1}, {1}, {1}, {nan}).passed);
  EXPECT_FALSE(compare_bounded({nan}, {nan}, {nan}, {1}).passed);
  EXPECT_FALSE(compare_bounded({inf}, {1}, {1}, {1}).passed);
  EXPECT_FALSE(compare_bounded({inf}, {inf}, {1}, {1}).passed);  // serial is wrong here, which excuses nothing
}

TEST(WithinBound, ReportsTheWorstByItsOwnBound) {
  const Judgement good = compare_bounded({1.25, 2.5, 3.25}, {1, 2, 3}, {1, 2, 3}, {1, 100, 1.5});
  EXPECT_TRUE(good.passed);
  EXPECT_EQ(good.worst_at, "element 0: openmp 1.25, serial 1");
  EXPECT_EQ(good.error, .25);
  EXPECT_EQ(good.bound, 1);

  const Judgement bad = compare_bounded({1, 3, 5, 4}, {1, 2, 3, 4}, {1, 2, 3, 4}, {1, .25, 1, 1});
  EXPECT_FALSE(bad.passed);
  EXPECT_EQ(bad.worst_at, "element 1: openmp 3, serial 2");
}

// What is no number is the worst of all, whatever comes after it.
TEST(WithinBound, ReportsWhatIsNoNumber) {
  const Judgement judgement = compare_bounded({1, nan, 3.5, 4}, {1, 2, 3, 4}, {1, 2, 3, 4}, {1, 1, 1, 1});
  EXPECT_FALSE(judgement.passed);
  EXPECT_EQ(judgement.worst_at.substr(0, judgement.worst_at.find(':')), "element 1");
}

TEST(WithinBound, KeepsAnEarlierFailure) {
  Judgement judgement{.verdict = Verdict::bounded, .worst_at = ""};
  const std::vector<float> right = {1}, wrong = {2};
  const std::vector<double> truth = {1}, rounding = {.5};
  within_bound(judgement, wrong, right, truth, rounding, element);
  within_bound(judgement, right, right, truth, rounding, element);
  EXPECT_FALSE(judgement.passed);
  EXPECT_EQ(judgement.worst_at, "element 0: openmp 2, serial 1");
}

// --- Whole steps. Each mistake is made in a step that is right but for it.

// A dam break, some frames after its lowest particles have met the floor.
Fluid<float> flowing() {
  Scene scene = load_scene("scenes/fluid/dam_break_5k.toml");
  Fluid<float> fluid = make_fluid(convert<float>(scene.model), scene.particles);
  for (int frame = 0; frame < 40; ++frame) serial::step_symmetric(fluid);
  return fluid;
}

// At rest in no gravity and without walls: momentum is conserved.
Fluid<float> floating() {
  Scene scene = load_scene("scenes/fluid/lattice_5k.toml");
  return make_fluid(convert<float>(scene.model), scene.particles);
}

constexpr int victim = 1234;  // the id of the particle that is done wrong

int place_of_victim(const Fluid<float>& fluid) { return id_order(fluid.particles)[victim]; }

// A right step, but for what `change` does to the accelerations by pressure, viscosity and gravity.
template <class Change>
void step_with(Fluid<float>& f, const Change& change) {
  serial::rebuild_grid(f.grid, f.particles, f.sorted);
  serial::densities_symmetric(f.model, f.grid, f.particles, f.neighbours, f.density);
  serial::forces_symmetric(f.model, f.grid, f.particles, f.neighbours, f.density, f.acceleration);
  change(f);
  serial::collisions(f.model, f.grid, f.particles, f.acceleration);
  serial::advance(f.model, f.grid, f.acceleration, f.particles);
}

void step_right(Fluid<float>& f) {
  step_with(f, [](Fluid<float>&) {});
}

void step_frozen(Fluid<float>&) {}

void step_shifting_one(Fluid<float>& f) {
  serial::step_symmetric(f);
  f.particles.position.x[place_of_victim(f)] += 1e-6f;
}

void step_pushing_one(Fluid<float>& f) {
  serial::step_symmetric(f);
  f.particles.half_velocity.z[place_of_victim(f)] += 1e-3f;
}

void step_without_viscosity_of_one(Fluid<float>& f) {
  step_with(f, [](Fluid<float>& f) {
    Fluid<float> inviscid = f;
    inviscid.model.viscosity_coefficient = 0;
    serial::forces_symmetric(inviscid.model, inviscid.grid, inviscid.particles, inviscid.neighbours, inviscid.density,
                             inviscid.acceleration);
    const int i = place_of_victim(f);
    f.acceleration.x[i] = inviscid.acceleration.x[i];
    f.acceleration.y[i] = inviscid.acceleration.y[i];
    f.acceleration.z[i] = inviscid.acceleration.z[i];
  });
}

void step_without_forces_of_one(Fluid<float>& f) {
  step_with(f, [](Fluid<float>& f) {
    const int i = place_of_victim(f);
    f.acceleration.x[i] = f.model.gravity.x, f.acceleration.y[i] = f.model.gravity.y, f.acceleration.z[i] = f.model.gravity.z;
  });
}

void step_without_walls(Fluid<float>& f) {
  const bool walls = std::exchange(f.model.walls, false);
  serial::step_symmetric(f);
  f.model.walls = walls;
}

void step_to_nan(Fluid<float>& f) {
  serial::step_symmetric(f);
  f.particles.velocity.y[place_of_victim(f)] = nan;
}

void step_swapping_ids(Fluid<float>& f) {
  serial::step_symmetric(f);
  std::swap(f.particles.id[0], f.particles.id[f.particles.count - 1]);
}

struct Mistake {
  const char* name;
  Step<float>* step;
};

const Mistake mistakes[] = {
    {"frozen", step_frozen},
    {"one particle shifted", step_shifting_one},
    {"one particle pushed", step_pushing_one},
    {"one particle without viscosity", step_without_viscosity_of_one},
    {"one particle without forces", step_without_forces_of_one},
    {"walls forgotten", step_without_walls},
    {"not a number", step_to_nan},
    {"two ids swapped", step_swapping_ids},
};

Judgement judge_one_step(const Fluid<float>& start, Step<float>* step) {
  Fluid<float> openmp = start, serial = start;
  step(openmp);
  serial::step_symmetric(serial);
  Judgement judgement{.verdict = Verdict::physical, .worst_at = ""};
  check_one_step(judgement, start, openmp, serial);
  return judgement;
}

TEST(CheckOneStep, PassesARightStepAndNoWrongOne) {
  const Fluid<float> start = flowing();
  EXPECT_TRUE(judge_one_step(start, step_right).passed);
  EXPECT_TRUE(judge_one_step(start, openmp::step_owner_gather).passed);
  for (const Mistake& mistake : mistakes) {
    // A step's velocities are means of its half velocities, which are what is compared.
    if (mistake.step == step_to_nan) continue;
    const Judgement judgement = judge_one_step(start, mistake.step);
    EXPECT_FALSE(judgement.passed) << mistake.name;
    EXPECT_GT(judgement.error, judgement.bound) << mistake.name << ": " << judgement.worst_at;
  }
}

TEST(CheckOneStep, NamesTheParticle) {
  const Fluid<float> start = flowing();
  for (Step<float>* step : {step_shifting_one, step_pushing_one, step_without_viscosity_of_one, step_without_forces_of_one}) {
    const std::string worst_at = judge_one_step(start, step).worst_at;
    EXPECT_NE(worst_at.find("of particle " + std::to_string(victim) + ":"), std::string::npos) << worst_at;
  }
}

Judgement judge_free_run(const Fluid<float>& start, const FreeRuns& runs, const Holds& holds, Step<float>* step) {
  Judgement judgement{.verdict = Verdict::physical, .worst_at = ""};
  check_free_run(judgement, runs, holds, start, step);
  return judgement;
}

TEST(CheckFreeRun, PassesARightStepAndNoWrongOne) {
  const Fluid<float> start = flowing();
  const FreeRuns runs = run_freely(start, 20);
  ASSERT_EQ(runs.frames.size(), 20u);
  const Holds holds{.inside_domain = true, .energy_falls_after = {}};
  EXPECT_TRUE(judge_free_run(start, runs, holds, step_right).passed);
  for (const Mistake& mistake : mistakes) EXPECT_FALSE(judge_free_run(start, runs, holds, mistake.step).passed) << mistake.name;
}

TEST(CheckFreeRun, SaysWhatBroke) {
  const Fluid<float> start = flowing();
  const FreeRuns runs = run_freely(start, 20);
  EXPECT_EQ(judge_free_run(start, runs, {}, step_to_nan).worst_at, "velocity.y of particle " + std::to_string(victim) + " is not finite after frame 1");
  FreeRuns forgotten = runs;
  forgotten.comparable = 0;  // then only what the scene says can tell
  EXPECT_TRUE(judge_free_run(start, forgotten, {}, step_shifting_one).passed);
  const auto step_out = [](Fluid<float>& f) {
    serial::step_symmetric(f);
    f.particles.position.y[place_of_victim(f)] = f.model.domain_min.y - 1e-4f;
  };
  EXPECT_EQ(judge_free_run(start, forgotten, {.inside_domain = true, .energy_falls_after = {}}, step_out).worst_at,
            "a particle is outside the domain after frame 1");
}

TEST(CheckFreeRun, SeesMomentumChange) {
  const Fluid<float> start = floating();
  FreeRuns runs = run_freely(start, 5);
  runs.comparable = 0;
  const Holds holds{.momentum_conserved = true, .energy_falls_after = {}};
  EXPECT_TRUE(judge_free_run(start, runs, holds, step_right).passed);
  const auto step_drifting = [](Fluid<float>& f) {
    serial::step_symmetric(f);
    for (int i = 0; i < f.particles.count; ++i) f.particles.half_velocity.x[i] += 1e-3f;
  };
  const Judgement judgement = judge_free_run(start, runs, holds, step_drifting);
  EXPECT_FALSE(judgement.passed);
  EXPECT_EQ(judgement.worst_at, "momentum changed after frame 1");
  // Half of the cube no longer pulls back when the other half pulls.
  const auto step_one_sided = [](Fluid<float>& f) {
    step_with(f, [](Fluid<float>& f) {
      for (int i = 0; i < f.particles.count; ++i)
        if (f.particles.id[i] < f.particles.count / 2) f.acceleration.x[i] = f.acceleration.y[i] = f.acceleration.z[i] = 0;
    });
  };
  EXPECT_FALSE(judge_free_run(start, runs, holds, step_one_sided).passed);
}

TEST(CheckLattice, FailsOnOneWrongDensityInside) {
  Fluid<float> f = floating();
  serial::rebuild_grid(f.grid, f.particles, f.sorted);
  serial::densities_symmetric(f.model, f.grid, f.particles, f.neighbours, f.density);
  const Fluid<double> lattice = convert<double>(f);
  const auto judge = [&] {
    Judgement judgement{.verdict = Verdict::bounded, .worst_at = ""};
    check_lattice_density(judgement, lattice, f.density);
    return judgement;
  };
  EXPECT_TRUE(judge().passed) << judge().worst_at;
  const Vectors<float>& p = f.particles.position;
  int inside = 0;  // the particle nearest to the middle
  for (int i = 0; i < f.particles.count; ++i) {
    const auto distance = [&](int k) { return std::hypot(p.x[k], p.y[k] - .01f, p.z[k]); };
    if (distance(i) < distance(inside)) inside = i;
  }
  for (const float wrong : {f.density[inside] * 1.0002f, f.density[inside] * .9998f, nan}) {
    const float right = std::exchange(f.density[inside], wrong);
    EXPECT_FALSE(judge().passed) << wrong;
    f.density[inside] = right;
  }
}

TEST(Facts, AreSeenToBreak) {
  Fluid<float> f = flowing();
  EXPECT_TRUE(first_not_finite(f).empty());
  EXPECT_TRUE(inside_domain(f));
  for (const float wrong : {nan, inf, -inf}) {
    Fluid<float> broken = f;
    broken.particles.half_velocity.z[victim] = wrong;
    EXPECT_FALSE(first_not_finite(broken).empty());
  }
  for (const float wrong : {nan, .0651f, -.0651f}) {
    Fluid<float> broken = f;
    broken.particles.position.x[victim] = wrong;
    EXPECT_FALSE(inside_domain(broken));
  }
}

// One particle at 2 m/s, 10 cm above the floor: E = m (v^2 / 2 + g h), P = m v.
TEST(Facts, EnergyAndMomentumAreThoseOfTheFormula) {
  Particles<float> p;
  p.resize(1);
  const Model<float> model = fluid::convert<float>(make_model(100));  // 1 g
  p.position.y[0] = model.domain_min.y + .1f;
  p.velocity.x[0] = p.half_velocity.x[0] = 2;
  const Fluid<float> f = make_fluid(model, p);
  EXPECT_NEAR(energy(f), 1e-3 * (2 + .98), 1e-9);
  EXPECT_NEAR(momentum(f).x, 2e-3, 1e-12);
  EXPECT_EQ(momentum(f).y, 0);
}

// --- Runs of the game cloth

using ClothStep = cloth::Step<float>;
using GameCloth = cloth::Cloth<float>;

// Falls on a sphere and from there to the floor.
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

// A step of its parts, right if nothing is changed.
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

// The thickness is left out: no particle is inside a body, but the bits are others.
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
  for (ClothStep* step : std::initializer_list<ClothStep*>{cloth::serial::step_chains, cloth_right, cloth::openmp::step_chains}) {
    const Judgement judgement = judge_run(scene, step);
    EXPECT_TRUE(judgement.passed) << judgement.worst_at;
    EXPECT_EQ(judgement.error, 0);
  }
}

// After one step, and after a hundred, when it has met both bodies.
TEST(CheckClothRun, FailsOnOneUlpOfOneParticle) {
  for (const int frames : {1, 100})
    for (ClothStep* step : {cloth_moved_by_one_ulp<0>, cloth_moved_by_one_ulp<1>, cloth_moved_by_one_ulp<2>}) {
      const Judgement judgement = judge_run(napkin(frames), step);
      EXPECT_FALSE(judgement.passed);
      EXPECT_GE(judgement.error, 1);
      EXPECT_EQ(judgement.worst_at.rfind("position of particle ", 0), 0u) << judgement.worst_at;
    }
  const Judgement judgement = judge_run(napkin(1), cloth_moved_by_one_ulp<0>);
  EXPECT_EQ(judgement.error, 1) << "the one that was moved, and no other";
  EXPECT_NE(judgement.worst_at.find("particle " + std::to_string(middle(cloth::convert<float>(napkin(1).cloth))) + ' '), std::string::npos)
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
  expect(cloth_to_nan, "a position that is not finite after step 1");
  expect(cloth_to_infinity, "a position that is not finite after step 1");
  expect(cloth_with_a_velocity_of_nan, "a position that is not finite after step 2");
  expect(cloth_with_one_in_the_sphere, particle + " is 0.080000 m inside a body after step 1");
  const Judgement through = judge_run(scene, cloth_without_bodies);
  EXPECT_FALSE(through.passed);
  EXPECT_NE(through.worst_at.find(" m inside a body after step "), std::string::npos) << through.worst_at;
}

// In the last step, too: there is none after it that would see.
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
  bodies.boxes = {{.centre = {2, 0, 0}, .half = {.5, .25, 1}, .axis = {{{0, 1, 0}, {0, 0, 1}, {1, 0, 0}}}}};  // turned: 1 along x
  EXPECT_EQ(depth_at(2.5f, 0, 0), .25);
  EXPECT_EQ(depth_at(2.875f, 0, 0), .125);
  EXPECT_EQ(depth_at(2, .375f, 0), .125);
  EXPECT_EQ(depth_at(2, 0, .25f), 0);

  // What nothing moves may be anywhere.
  GameCloth pinned = whole;
  pinned.inverse_mass[i] = 0;
  pinned.position.x[i] = 2;
  EXPECT_EQ(deepest_inside(bodies, pinned).depth, 0);
}

// Converged: what a form leaves after enough iterations against what the original order leaves. Without gravity the scene is one
// relaxation, with gravity many steps.
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
    const GameCloth start = cloth::convert<float>(cloth::load_scene("scenes/cloth/" + std::string(name) + ".toml").cloth);
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
