// The verifier's checks of whole fluid steps and runs. Each test plants one mistake in a step that is right otherwise.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "common/fluid/advance.h"
#include "common/fluid/collisions.h"
#include "common/fluid/convert.h"
#include "common/fluid/densities.h"
#include "common/fluid/forces.h"
#include "common/fluid/id_order.h"
#include "common/fluid/rebuild_grid.h"
#include "common/fluid/scene.h"
#include "verify/arrays.h"
#include "verify/fluid/bounds.h"
#include "verify/fluid/run.h"

namespace lockstep::verify {
namespace {

using namespace fluid;

constexpr float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();

// A dam break, some frames after its lowest particles have reached the floor.
Fluid<float> flowing() {
  Scene scene = load_scene("scenes/fluid/dam_break_5k.toml");
  Fluid<float> fluid = make_fluid(convert<float>(scene.model), scene.particles);
  for (int frame = 0; frame < 40; ++frame) serial::step_symmetric(fluid);
  return fluid;
}

// A lattice at rest, without gravity and walls: momentum is conserved.
Fluid<float> floating() {
  Scene scene = load_scene("scenes/fluid/lattice_5k.toml");
  return make_fluid(convert<float>(scene.model), scene.particles);
}

constexpr int victim = 1234;  // the id of the particle that gets the mistake

int place_of_victim(const Fluid<float>& fluid) { return id_order(fluid.particles)[victim]; }

// A correct step, except for the change that `change` makes to the accelerations.
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
    f.acceleration.x[i] = f.model.gravity.x, f.acceleration.y[i] = f.model.gravity.y,
    f.acceleration.z[i] = f.model.gravity.z;
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
    // The check compares half velocities; velocities are their means.
    if (mistake.step == step_to_nan) continue;
    const Judgement judgement = judge_one_step(start, mistake.step);
    EXPECT_FALSE(judgement.passed) << mistake.name;
    EXPECT_GT(judgement.error, judgement.bound) << mistake.name << ": " << judgement.worst_at;
  }
}

TEST(CheckOneStep, NamesTheParticle) {
  const Fluid<float> start = flowing();
  for (Step<float>* step :
       {step_shifting_one, step_pushing_one, step_without_viscosity_of_one, step_without_forces_of_one}) {
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
  for (const Mistake& mistake : mistakes)
    EXPECT_FALSE(judge_free_run(start, runs, holds, mistake.step).passed) << mistake.name;
}

TEST(CheckFreeRun, SaysWhatBroke) {
  const Fluid<float> start = flowing();
  const FreeRuns runs = run_freely(start, 20);
  EXPECT_EQ(judge_free_run(start, runs, {}, step_to_nan).worst_at,
            "velocity.y of particle " + std::to_string(victim) + " is not finite after frame 1");
  FreeRuns forgotten = runs;
  forgotten.comparable = 0;  // then only the scene's own statements are checked
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
  // Half of the cube exerts forces without reactions.
  const auto step_one_sided = [](Fluid<float>& f) {
    step_with(f, [](Fluid<float>& f) {
      for (int i = 0; i < f.particles.count; ++i)
        if (f.particles.id[i] < f.particles.count / 2)
          f.acceleration.x[i] = f.acceleration.y[i] = f.acceleration.z[i] = 0;
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
  EXPECT_EQ(first_not_finite(f), "");
  EXPECT_TRUE(inside_domain(f));
  for (const float wrong : {nan, inf, -inf}) {
    Fluid<float> broken = f;
    broken.particles.half_velocity.z[victim] = wrong;
    EXPECT_NE(first_not_finite(broken), "");
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

}  // namespace
}  // namespace lockstep::verify
