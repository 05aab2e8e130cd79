// Scenes of the production fluid: what they say, and what is refused.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "common/input_error.h"
#include "common/production_fluid/scene.h"
#include "tests/temporary_folder.h"

namespace lockstep::production_fluid {
namespace {

struct ProductionFluidScene : TemporaryFolder {
  Fluid<float> load(const std::string& rest) const {
    write_bytes(path("a.toml"), "kind = \"production_fluid\"\ncells = [10, 20, 30]\n" + rest);
    return load_scene(path("a.toml")).fluid;
  }
  std::string refusal(const std::string& rest) const {
    try {
      load(rest);
    } catch (const InputError& error) {
      return std::string(error.what()).substr(path("a.toml").size());
    }
    return "";
  }
};

TEST_F(ProductionFluidScene, SaysWhatItSays) {
  const Fluid<float> fluid = load(
      "spacing = 0.1\nopen_top = true\n[pool]\nheight = 0.5\n[[liquid]]\ncentre = [0.45, 1.45, 1.45]\nradius = 0.2\n"
      "[[obstacle]]\ncentre = [0.5, 0.2, 1.5]\nhalf = [0.1, 0.1, 0.1]\n");
  EXPECT_EQ(fluid.spacing, .1f);
  EXPECT_TRUE(fluid.open_top);
  EXPECT_FLOAT_EQ(fluid.phi(0, 2, 7), .25f - .5f);
  EXPECT_FLOAT_EQ(fluid.phi(4, 14, 14), -.2f);
  EXPECT_FLOAT_EQ(fluid.phi(4, 14, 17), .3f - .2f);
  EXPECT_FLOAT_EQ(fluid.solid(4, 1, 14), -.05f);
  EXPECT_FLOAT_EQ(fluid.solid(4, 5, 14), .55f - .3f);
  EXPECT_EQ(fluid.solid(-1, 5, 14), -1);  // a wall
  EXPECT_EQ(fluid.velocity.u.nx, 11);
  EXPECT_EQ(fluid.velocity.v(3, 20, 29), 0);
}

TEST_F(ProductionFluidScene, PoolsHaveWaves) {
  const Fluid<float> fluid = load("[pool]\nheight = 0.5\namplitude = 0.1\nhalf_waves = [2, 3]\nshift = 0.4\n");
  const double pi = std::acos(-1.), x = .35, y = .75, z = 1.25;
  EXPECT_NEAR(fluid.phi(3, 7, 12), y - .5 - .1 * std::cos(2 * pi * x - .4) * std::cos(3 * pi * z / 3), 1e-6);
}

TEST_F(ProductionFluidScene, MeshesAreSolid) {
  write_bytes(path("a.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  const Fluid<float> fluid = load("[pool]\nheight = 2\n[mesh]\nfile = \"a.obj\"\n");
  EXPECT_FLOAT_EQ(fluid.solid(1, 1, 0), -.05f);
  EXPECT_GT(fluid.solid(9, 9, 9), 0);
}

TEST_F(ProductionFluidScene, ASourceIsEnough) {
  write_bytes(path("a.toml"),
              "kind = \"production_fluid\"\ncells = [10, 20, 30]\n[[source]]\ncentre = [0.1, 0.2, 0.3]\nradius = 0.05\n"
              "velocity = [1, -2, 3]\nuntil = 0.5\n[[source]]\ncentre = [0.5, 1, 1]\nradius = 0.1\n");
  const Scene scene = load_scene(path("a.toml"));
  ASSERT_EQ(scene.model.sources.size(), 2u);
  const Source& first = scene.model.sources[0];
  EXPECT_EQ(first.centre.z, .3);
  EXPECT_EQ(first.radius, .05);
  EXPECT_EQ(first.velocity.y, -2);
  EXPECT_EQ(first.until, .5);
  EXPECT_EQ(scene.model.sources[1].velocity.x, 0);
  EXPECT_TRUE(std::isinf(scene.model.sources[1].until));
  EXPECT_GT(scene.fluid.phi(3, 10, 10), 0);  // nothing has flowed yet
}

TEST_F(ProductionFluidScene, RefusesWhatIsWrong) {
  EXPECT_EQ(refusal(""), ":1:1: liquid, pool or source is missing");
  EXPECT_EQ(refusal("[[liquid]]\ncentre = [9, 9, 9]\nradius = 0.1\n"), ":1:1: no liquid: every cell is air or solid");
  EXPECT_EQ(refusal("flow = \"up\"\n[pool]\nheight = 1\n"),
            ":3:8: flow: expected \"rest\", \"swirl\", \"turn\", \"enright\" or \"strain\"");
  EXPECT_EQ(refusal("[[liquid]]\ncentre = [0, 0, 0]\n"), ":3:1: expected one of radius and half");
}

}  // namespace
}  // namespace lockstep::production_fluid
