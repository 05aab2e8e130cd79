// A run starts settled (the key `rest` of rigid scenes).
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <vector>

#include "common/rigid/world.h"
#include "verify/simulation.h"

namespace lockstep {
namespace {

std::vector<float> speeds(const verify::Simulation& simulation) {
  const auto bytes = simulation.state[1].bytes();
  std::vector<rigid::Motion<float>> motion(bytes.size() / sizeof(rigid::Motion<float>));
  std::memcpy(motion.data(), bytes.data(), bytes.size());
  std::vector<float> speeds;
  for (const auto& each : motion) speeds.push_back(std::sqrt(dot(each.velocity, each.velocity)));
  return speeds;
}

// Without rest, 8,288 bricks are faster than 5 cm/s after the first step: they fall until their contacts bear them.
TEST(RigidRest, TheCastleStandsStillWhenTheBallIsShot) {
  verify::RunOptions options;
  options.scene = "scenes/rigid/castle_hit.toml";
  const verify::Simulation simulation = verify::make_simulation(options);
  const float shot = std::sqrt(8.f * 8 + 40 * 40);
  for (const bool stepped : {false, true}) {
    if (stepped) simulation.step();
    int fast = 0;
    for (const float speed : speeds(simulation)) {
      if (speed <= .05f) continue;
      ++fast;
      EXPECT_NEAR(speed, shot, .01f);
    }
    EXPECT_EQ(fast, 1);  // the ball
  }
}

}  // namespace
}  // namespace lockstep
