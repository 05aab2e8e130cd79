// Water: stiff enough that its flow is far below the speed of sound, it keeps its volume and loses energy
// (notes/fluid.md, "Water"). Run from the root of the repository.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/fluid/fluid.h"
#include "common/fluid/scene.h"
#include "common/fluid/step.h"
#include "tests/fluid_states.h"
#include "verify/arrays.h"
#include "verify/fluid/run.h"

namespace lockstep::fluid {
namespace {

TEST(FluidWater, KeepsItsVolumeAndLosesEnergy) {
  const Scene scene = load_scene("scenes/fluid/water_5k.toml");
  Fluid<float> f = make_fluid(convert<float>(scene.model), scene.particles);
  const double rest_density = .5 * scene.model.twice_rest_density, sound = std::sqrt(1600);
  const int count = f.particles.count, frames = static_cast<int>(.3 / scene.model.time_step);  // the splash, and back
  const double start = verify::energy(f);
  double fastest = 0, densest = 0, mean = 0, energy = start;
  at_thread_counts({1}, [&](int) {  // the same bits as at any other count
    for (int frame = 0; frame < frames; ++frame) {
      openmp::step_pair_lists(f);
      ASSERT_TRUE(verify::first_not_finite(f).empty()) << "frame " << frame;
      double sum = 0;
      for (int i = 0; i < count; ++i) {
        const Vector3<float> v = load(f.particles.velocity, i);
        fastest = std::max<double>(fastest, std::sqrt(dot(v, v)));
        densest = std::max<double>(densest, f.density[i]);
        sum += f.density[i];
      }
      mean = std::max(mean, sum / count);
      if (frame % 500 == 499) {
        EXPECT_LT(verify::energy(f), energy) << "frame " << frame;
        energy = verify::energy(f);
      }
    }
  });
  EXPECT_LT(fastest / sound, .15);
  EXPECT_LT(mean / rest_density, 1.01);
  EXPECT_LT(densest / rest_density, 1.1);  // one drop that hits a wall
  std::printf(
      "  Mach number %.3f, density at most %.3f of that at rest, %.4f in the mean, energy %.3f of the start's\n",
      fastest / sound, densest / rest_density, mean / rest_density, energy / start);
}

// The keys are the model's constants, and the defaults fluidanimate's.
TEST(FluidWater, KeysSetTheModel) {
  const Model<double> peer = make_model(200),
                      own = make_model(
                          200,
                          {.stiffness = 6, .viscosity = .8, .rest_density = 500, .time_step = .002, .cohesion = false});
  EXPECT_EQ(peer.time_step, .001);
  EXPECT_EQ(peer.least_density, 0);
  EXPECT_EQ(peer.twice_rest_density, 2000);
  EXPECT_DOUBLE_EQ(own.pressure_coefficient, peer.pressure_coefficient);  // twice the stiffness, half the mass
  EXPECT_DOUBLE_EQ(own.viscosity_coefficient, peer.viscosity_coefficient);
  EXPECT_DOUBLE_EQ(own.density_coefficient, .5 * peer.density_coefficient);
  EXPECT_EQ(own.twice_rest_density, 1000);
  EXPECT_EQ(own.least_density, 500);
  EXPECT_EQ(own.time_step, .002);
}

}  // namespace
}  // namespace lockstep::fluid
