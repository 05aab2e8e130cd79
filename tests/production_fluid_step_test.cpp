// Frames of the production fluid: what physics says of them, and what the two versions have in common.
#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "common/production_fluid/step.h"
#include "tests/production_fluids.h"
#include "verify/arrays.h"

namespace lockstep::production_fluid {
namespace {

template <class Real>
struct Moving {
  Model model;
  Liquid<Real> liquid;
  StepMemory<Real> memory;

  Moving(const Fluid<Real>& fluid, const Model& of) : model(of) {
    liquid.fluid = fluid;
    serial::start(model, liquid, memory);
  }
  void go(Step<Real>* step, int frames) {
    for (int k = 0; k < frames; ++k) step(model, liquid, memory);
  }
};

template <class Real>
double fastest(const Faces<Real>& faces) {
  double most = 0;
  for (const Field<Real>* component : {&faces.u, &faces.v, &faces.w})
    for_each_place(*component,
                   [&](int x, int y, int z) { most = std::max(most, std::abs(double((*component)(x, y, z)))); });
  return most;
}

// The centre of the liquid's volume, m.
Vector3<double> centre_of(const Fluid<float>& fluid) {
  Vector3<double> sum = {0, 0, 0};
  double volume = 0;
  for_each_place(fluid.phi, [&](int x, int y, int z) {
    const double cell = liquid_share(fluid.phi(x, y, z), fluid.spacing);
    sum = sum + cell * Vector3<double>{x + .5, y + .5, z + .5}, volume += cell;
  });
  return (fluid.spacing / volume) * sum;
}

// A column stands in the pool, from floor to top, and a block lies on its floor. An obstacle whose top is just above
// the surface would not do: within it the level set goes on from its sides and from its top, and is flat no more.
template <class Real>
Fluid<Real> pool_around_obstacles(double height) {
  const double h = 1. / 16;
  Fluid<Real> fluid = make_fluid<Real>(16, 16, 16, h, [&](double, double y, double) { return y - height; });
  for_each_place(fluid.solid, [&](int x, int y, int z) {
    const double px = (x + .5) * h, py = (y + .5) * h, pz = (z + .5) * h;
    const double column = std::max(std::abs(px - .5) - .125, std::abs(pz - .5) - .125);
    const double block = std::max({std::abs(px - .125) - .125, std::abs(pz - .25) - .125, py - .125});
    fluid.solid(x, y, z) = static_cast<Real>(std::min(column, block));
  });
  return fluid;
}

// The pressure of a pool at rest is linear, so the discrete system has it exactly: what is left of gravity is what the
// solve leaves, its tolerance times the norm of the right-hand side, at most sqrt(cells) g dt. A substep is at most
// cfl h / sqrt(h g). It does not add up in the velocity, since each solve takes out what the one before has left; the
// surface follows it.
template <class Real>
void expect_rest(double height, double tolerance, int substeps, Step<Real>* step) {
  const double h = 1. / 16, g = 9.81, dt = .9 * h / std::sqrt(h * g), cells = 16 * 16 * 16;
  Model model;
  model.pressure.stop.tolerance = tolerance;
  Moving<Real> moving(pool_around_obstacles<Real>(height), model);
  const Field<Real> phi = moving.liquid.fluid.phi;
  int made = 0, frames = 0;
  for (; made < substeps; ++frames) moving.go(step, 1), made += moving.memory.substeps;
  const double speed = tolerance * std::sqrt(cells) * g * dt, u = std::numeric_limits<Real>::epsilon();
  EXPECT_LT(fastest(moving.liquid.fluid.velocity), speed + 100 * u * g * dt) << height;
  // In the second term, a few roundings of redistancing a substep.
  const double way = speed * frames * model.frame + 4 * u * h * made;
  double most = 0;
  for_each_place(phi, [&](int x, int y, int z) {
    if (std::abs(phi(x, y, z)) < h)
      most = std::max(most, std::abs(double(moving.liquid.fluid.phi(x, y, z)) - phi(x, y, z)));
  });
  EXPECT_LT(most, way) << height;
}

TEST(ProductionFluidStep, APoolAtRestStaysAtRestForAThousandSteps) {
  expect_rest<float>(.43, 1e-6, 1000, openmp::step_multigrid);
}

TEST(ProductionFluidStep, APoolOfAnyHeightStaysAtRest) {
  // Not where centres of cells are in the surface: there theta is less than its bound.
  for (const double height : {.4, .43, 7.4 / 16, 8. / 16}) {
    expect_rest<float>(height, 1e-6, 40, serial::step_mic);
    expect_rest<float>(height, 1e-6, 40, openmp::step_marching);
    expect_rest<double>(height, 1e-12, 40, serial::step_mic);
  }
}

// Nothing but gravity acts on a drop in the air: its pressure is zero, its velocity is that of gravity in the middle of
// the next substep. With that, a substep moves the drop by what gravity does in it, whatever the substeps' lengths:
// after a time t it has fallen by g t^2 / 2.
TEST(ProductionFluidStep, ADropFallsFreely) {
  const double h = 1. / 16, g = 9.81, frame = 1. / 24, t = 4 * frame;
  const Fluid<float> fluid = make_fluid<float>(
      16, 40, 16, h, [](double x, double y, double z) { return std::hypot(x - .5, y - 1.8, z - .5) - .25; });
  for (Step<float>* step : {serial::step_mic, openmp::step_mic}) {
    Moving<float> moving(fluid, {});
    const double before = centre_of(moving.liquid.fluid).y;
    int substeps = 0;
    for (int k = 0; k < 4; ++k) moving.go(step, 1), substeps += moving.memory.substeps;
    EXPECT_EQ(moving.memory.iterations, 0);
    const Fluid<float>& now = moving.liquid.fluid;
    const double gained = g * (t + .5 * moving.liquid.planned);
    // Rounding of a sum of substeps, and of interpolation between equal values.
    for_each_place(now.phi, [&](int x, int y, int z) {
      if (now.phi(x, y, z) > 0) return;
      EXPECT_NEAR(now.velocity.v(x, y, z), -gained, 1e-6 * substeps * gained);
      EXPECT_NEAR(now.velocity.u(x, y, z), 0, 1e-6);
    });
    EXPECT_NEAR(before - centre_of(now).y, g * t * t / 2, .1 * h);
  }
}

// A ball of five cells' radius. Advection of first order wears it away, most where it moves fastest, so its centre may
// be off by a part of what is lost; .18 of a cell has been seen.
Fluid<float> ball(const Vector3<double>& centre) {
  return make_fluid<float>(32, 32, 32, 1. / 32, [&](double x, double y, double z) {
    const Vector3<double> away = Vector3<double>{x, y, z} - centre;
    return std::sqrt(dot(away, away)) - .15;
  });
}

void expect_near(const Vector3<double>& a, const Vector3<double>& b) {
  const double near = .25 / 32;
  EXPECT_NEAR(a.x, b.x, near);
  EXPECT_NEAR(a.y, b.y, near);
  EXPECT_NEAR(a.z, b.z, near);
}

// The velocity is that of a turn, once in 2 pi s: half a turn takes the ball to the other side of the middle.
TEST(ProductionFluidStep, AGivenVelocityIsFollowed) {
  Fluid<float> fluid = ball({.5, .7, .5});
  Field<float>&u = fluid.velocity.u, &v = fluid.velocity.v;
  for_each_place(u, [&](int x, int y, int z) { u(x, y, z) = float(.5 - (y + .5) / 32); });
  for_each_place(v, [&](int x, int y, int z) { v(x, y, z) = float((x + .5) / 32 - .5); });
  Moving<float> moving(fluid, {.gravity = {0, 0, 0}, .frame = std::acos(-1.) / 20, .given = true});
  moving.go(openmp::step_mic, 10);
  expect_near(centre_of(moving.liquid.fluid), {.3, .5, .5});
  moving.go(openmp::step_mic, 10);
  expect_near(centre_of(moving.liquid.fluid), {.5, .3, .5});
}

// There and back: cos(pi t) from 0 to 1/2 adds up to 1 / pi.
TEST(ProductionFluidStep, AGivenVelocityTurnsRound) {
  Fluid<float> fluid = ball({.3, .5, .5});
  for_each_cell(fluid.velocity.u, [](float& u) { u = 1; });
  Moving<float> moving(fluid, {.gravity = {0, 0, 0}, .frame = .1, .given = true, .period = 1});
  moving.go(serial::step_mic, 5);
  expect_near(centre_of(moving.liquid.fluid), {.3 + 1 / std::acos(-1.), .5, .5});
  moving.go(serial::step_mic, 5);
  expect_near(centre_of(moving.liquid.fluid), {.3, .5, .5});
}

TEST(ProductionFluidStep, FramesEndOnSubstepsOfAboutEqualLength) {
  EXPECT_EQ(next_substep(.5, .4), .4);
  EXPECT_EQ(next_substep(.5, .5), .5);
  EXPECT_DOUBLE_EQ(next_substep(.5, .6), .306);
  EXPECT_EQ(next_substep(.5, 1.1), .5);
}

// A drop falls into a pool beside a block. Particles escape, spray flies and comes back, blocks are reseeded at the
// end.
Fluid<float> splash() {
  const double h = 1. / 16;
  Fluid<float> fluid = make_fluid<float>(21, 24, 19, h, [](double x, double y, double z) {
    return std::min(y - .4, std::hypot(x - .6, y - .85, z - .55) - .2);
  });
  for_each_place(fluid.solid, [&](int x, int, int z) {
    fluid.solid(x, 0, z) = static_cast<float>(h / 2 - .01);
    for (int y = 0; y < fluid.ny; ++y)
      fluid.solid(x, y, z) =
          static_cast<float>(std::hypot((x + .5) * h - .3, (y + .5) * h - .2, (z + .5) * h - .3) - .15);
  });
  fluid.open_top = true;
  return fluid;
}

TEST(ProductionFluidStep, TwentyFramesHaveTheSerialBits) {
  const int before = omp_get_max_threads();
  struct Twins {
    Step<float>*serial, *openmp;
  };
  const Twins multigrid = {serial::step_multigrid, openmp::step_multigrid}, mic = {serial::step_mic, openmp::step_mic},
              marching = {serial::step_marching, openmp::step_marching};
  for (const auto& [serial, openmp] : {multigrid, mic, marching}) {
    Moving<float> expected(splash(), {});
    std::vector<std::uint64_t> hashes;
    int most_drops = 0;
    for (int k = 0; k < 20; ++k) {
      expected.go(serial, 1);
      hashes.push_back(verify::hash_of(expected.liquid));
      most_drops = std::max(most_drops, expected.liquid.spray.count);
    }
    EXPECT_GT(most_drops, 0);
    EXPECT_GT(expected.liquid.particles.count, 1000);
    for (const int threads : {1, 2, 3, 4, 8}) {
      omp_set_num_threads(threads);
      Moving<float> moving(splash(), {});
      for (int k = 0; k < 20; ++k) {
        moving.go(openmp, 1);
        ASSERT_EQ(verify::hash_of(moving.liquid), hashes[k]) << "frame " << k << ", " << threads << " threads";
      }
    }
  }
  omp_set_num_threads(before);
}

// What a frame begins with is all that it needs.
TEST(ProductionFluidStep, GoesOnFromACopyOfTheLiquid) {
  Moving<float> moving(splash(), {});
  moving.go(openmp::step_mic, 3);
  Moving<float> other(splash(), {});
  other.liquid = moving.liquid;
  moving.go(openmp::step_mic, 2), other.go(openmp::step_mic, 2);
  EXPECT_EQ(verify::hash_of(other.liquid), verify::hash_of(moving.liquid));
}

TEST(ProductionFluidStep, NoParticlesAreALevelSetAlone) {
  Moving<float> moving(splash(), {.per_block = 0});
  moving.go(openmp::step_mic, 3);
  EXPECT_EQ(moving.liquid.particles.count, 0);
  EXPECT_EQ(verify::first_not_finite(moving.liquid), "");
}

}  // namespace
}  // namespace lockstep::production_fluid
