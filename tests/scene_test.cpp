// Scenes: those of the repository load, and a bad one is refused at the line and column of the mistake.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>

#include "common/fluid/file.h"
#include "common/fluid/scene.h"
#include "tests/temporary_folder.h"

namespace lockstep::fluid {
namespace {

struct SceneTest : TemporaryFolder {
  Scene load(const std::string& toml) const {
    write_bytes(path("a.toml"), toml);
    return load_scene(path("a.toml"));
  }

  // The message without the folder: "a.toml:line:column: ...".
  std::string error(const std::string& toml) const {
    const std::string message = error_of([&] { load(toml); });
    EXPECT_EQ(message.rfind(folder, 0), 0u) << message;
    EXPECT_EQ(files(), 1);
    return message.substr(folder.size() + 1);
  }
};

const std::string head = "kind = \"fluid\"\nparticles_per_metre = 200\n";
const std::string block = "[[block]]\nmin = [0, 0, 0]\nmax = [0.01, 0.015, 0.02]\n";  // 2 x 3 x 4 particles

// Run from the root of the repository, as `make test` does.
TEST(Scenes, OfTheRepositoryLoad) {
  const std::map<std::string, int> counts{
      {"dam_break_5k", 5040},
      {"dam_break_35k", 35100},
      {"dam_break_100k", 100352},
      {"dam_break_500k", 502272},
      {"dam_break_2m", 2010048},
      {"lattice_5k", 4913},
      {"lattice_35k", 35937},
      {"lattice_100k", 103823},
      {"lattice_500k", 512000},
      {"clump", 4096},
      {"single", 1},
      {"splash", 25515},
      {"adrift", 1000},
      {"water_5k", 5544},
      {"water_35k", 35100},
  };
  std::map<std::string, int> found;
  for (const auto& file : std::filesystem::directory_iterator("scenes/fluid")) {
    const Scene scene = load_scene(file.path().string());
    found[scene.name] = scene.particles.count;
    EXPECT_EQ(scene.holds.lattice_density, scene.name.starts_with("lattice_")) << scene.name;
    EXPECT_EQ(scene.model.walls, !scene.name.starts_with("lattice_") && scene.name != "adrift") << scene.name;
  }
  EXPECT_EQ(found, counts);
}

TEST_F(SceneTest, SaysWhatItSays) {
  const Scene scene = load(head + "frames = 7\nwalls = false\ngravity = [1, 2.5, -3]\nseed = 0\n" + block +
                           "velocity = [4, 5, 6]\n[holds]\nmomentum_conserved = true\nenergy_falls_after = 5\n");
  EXPECT_EQ(scene.name, "a");
  EXPECT_EQ(scene.path, path("a.toml"));
  EXPECT_EQ(scene.frames, 7);
  EXPECT_EQ(scene.model.particles_per_metre, 200);
  EXPECT_FALSE(scene.model.walls);
  EXPECT_EQ(scene.model.gravity.y, 2.5);
  EXPECT_TRUE(scene.holds.momentum_conserved);
  EXPECT_FALSE(scene.holds.inside_domain);
  EXPECT_EQ(scene.holds.energy_falls_after, 5);

  const Particles<float>& p = scene.particles;
  ASSERT_EQ(p.count, 2 * 3 * 4);
  const int i = (3 * 3 + 2) * 2 + 1;  // x fastest, then y, then z
  EXPECT_EQ(p.id[i], i);
  EXPECT_FLOAT_EQ(p.position.x[i], .0075f);
  EXPECT_FLOAT_EQ(p.position.y[i], .0125f);
  EXPECT_FLOAT_EQ(p.position.z[i], .0175f);
  EXPECT_EQ(p.velocity.x[i], 4);
  EXPECT_EQ(p.half_velocity.z[i], 6);
}

TEST_F(SceneTest, HasDefaults) {
  const Scene scene = load(head + block);
  EXPECT_EQ(scene.frames, 100);
  EXPECT_TRUE(scene.model.walls);
  EXPECT_EQ(scene.model.gravity.y, -9.8);
  EXPECT_FALSE(scene.holds.energy_falls_after);
  EXPECT_EQ(scene.particles.velocity.x[0], 0);
}

TEST_F(SceneTest, NumbersParticlesBlockByBlock) {
  const Particles<float> p = load(head + block + block + "spacing = 0.01\n").particles;
  ASSERT_EQ(p.count, 24 + 1 * 1 * 2);
  EXPECT_EQ(p.id[25], 25);
  EXPECT_FLOAT_EQ(p.position.z[25], .015f);
}

// Against the published splitmix64 sequence of this seed: jitter must be the same on every platform.
TEST_F(SceneTest, JittersBySplitmix64) {
  const std::string two = "[[block]]\nmin = [0, 0, 0]\nmax = [2, 1, 1]\nspacing = 1\njitter = 1\n";
  const Particles<float> p = load(head + "seed = 1234567\n" + two).particles;
  ASSERT_EQ(p.count, 2);
  const auto fraction = [](std::uint64_t x) { return static_cast<float>(static_cast<double>(x) * 0x1p-64); };
  EXPECT_FLOAT_EQ(p.position.x[0], fraction(6457827717110365317u));
  EXPECT_FLOAT_EQ(p.position.y[0], fraction(3203168211198807973u));
  EXPECT_FLOAT_EQ(p.position.z[0], fraction(9817491932198370423u));
  EXPECT_FLOAT_EQ(p.position.x[1], 1 + fraction(4593380528125082431u));
}

TEST_F(SceneTest, JitterStaysInItsCube) {
  const Particles<float> still = load(head + block).particles, moved = load(head + block + "jitter = 0.5\n").particles;
  float farthest = 0;
  for (int i = 0; i < still.count; ++i)
    farthest = std::max(farthest, std::abs(moved.position.x[i] - still.position.x[i]));
  EXPECT_LE(farthest, .25f * .005f * 1.001f);
  EXPECT_GE(farthest, .2f * .005f);
}

TEST_F(SceneTest, TakesAFluidFile) {
  const Particles<float> particles = load(head + block).particles;
  write_fluid(path("b.fluid"), 200, particles);
  const Scene scene = load_scene(path("b.fluid"));
  EXPECT_EQ(scene.name, "b");
  EXPECT_EQ(scene.frames, 1);
  EXPECT_EQ(scene.model.smoothing_length, make_model(200).smoothing_length);
  EXPECT_EQ(scene.particles.position.x, particles.position.x);
}

TEST_F(SceneTest, RefusesWhatIsNoScene) {
  EXPECT_EQ(error_of([&] { load_scene(path("none.toml")); }),
            path("none.toml") + ": cannot be read: No such file or directory");
  EXPECT_EQ(error_of([&] { load_scene(folder); }), folder + ": is a directory, expected a file");
  EXPECT_EQ(error("kind = fluid\n").rfind("a.toml:1:9: ", 0), 0u);
  EXPECT_EQ(error(head + "seed = 1\nseed = 1\n").rfind("a.toml:4:8: ", 0), 0u);
  EXPECT_EQ(error("\xff\xfe\x01").rfind("a.toml:1:1: ", 0), 0u);
}

TEST_F(SceneTest, RefusesUnknownAndMissingKeys) {
  EXPECT_EQ(error(head + "frmes = 3\n" + block),
            "a.toml:3:1: unknown key frmes, expected one of: kind, particles_per_metre, block, frames, walls, gravity, "
            "stiffness, viscosity, rest_density, time_step, cohesion, seed, holds");
  EXPECT_EQ(error(head + block + "  spacng = 3\n"),
            "a.toml:6:3: unknown key spacng, expected one of: min, max, spacing, jitter, velocity");
  EXPECT_EQ(
      error(head + block + "[holds]\nmass_conserved = true\n"),
      "a.toml:7:1: unknown key mass_conserved, expected one of: momentum_conserved, inside_domain, lattice_density, "
      "energy_falls_after");
  EXPECT_EQ(error(""), "a.toml:1:1: kind is missing");
  EXPECT_EQ(error(head), "a.toml:1:1: block is missing");
  EXPECT_EQ(error("kind = \"fluid\"\n" + block), "a.toml:1:1: particles_per_metre is missing");
  EXPECT_EQ(error(head + block + "[[block]]\nmin = [0, 0, 0]\n"), "a.toml:6:1: max is missing");
}

TEST_F(SceneTest, RefusesWrongValues) {
  const auto with = [](const std::string& line) { return head + line + '\n' + block; };
  EXPECT_EQ(error("kind = \"cloth\"\nparticles_per_metre = 200\n" + block), "a.toml:1:8: kind: expected \"fluid\"");
  EXPECT_EQ(error("kind = 1\nparticles_per_metre = 200\n" + block), "a.toml:1:8: kind: expected \"fluid\"");
  for (const char* value : {"0", "-1", "nan", "inf", "1e-7", "\"200\"", "true", "[200]"})
    EXPECT_EQ(error("kind = \"fluid\"\nparticles_per_metre = " + std::string(value) + '\n' + block),
              "a.toml:2:23: particles_per_metre: expected a number from 1e-6 to 1e6");
  for (const char* value : {"0", "-1", "1.0", "2147483648", "\"1\""})
    EXPECT_EQ(error(with("frames = " + std::string(value))),
              "a.toml:3:10: frames: expected a whole number from 1 to 2147483647");
  EXPECT_EQ(error(with("seed = -1")), "a.toml:3:8: seed: expected a whole number from 0 to 9223372036854775807");
  EXPECT_EQ(error(with("walls = 1")), "a.toml:3:9: walls: expected true or false");
  EXPECT_EQ(error(with("gravity = 9.8")), "a.toml:3:11: gravity: expected three finite numbers [x, y, z] in m/s^2");
  EXPECT_EQ(error(with("gravity = [0, -9.8]")),
            "a.toml:3:11: gravity: expected three finite numbers [x, y, z] in m/s^2");
  EXPECT_EQ(error(with("gravity = [0, nan, 0]")),
            "a.toml:3:15: gravity: expected three finite numbers [x, y, z] in m/s^2");
  EXPECT_EQ(error(with("gravity = [0, 1e19, 0]")),
            "a.toml:3:15: gravity: expected three finite numbers [x, y, z] in m/s^2");
  EXPECT_EQ(error(with("holds = true")), "a.toml:3:9: holds: expected a table [holds]");
  EXPECT_EQ(error(with("holds.energy_falls_after = -1")),
            "a.toml:3:28: energy_falls_after: expected a whole number from 0 to 2147483647");
}

TEST_F(SceneTest, RefusesWrongBlocks) {
  EXPECT_EQ(error(head + "block = []\n"), "a.toml:3:9: block: expected one or more tables [[block]]");
  EXPECT_EQ(error(head + "[block]\n"), "a.toml:3:1: block: expected one or more tables [[block]]");
  EXPECT_EQ(error(head + "block = [1]\n"), "a.toml:3:10: block: expected a table [[block]]");
  EXPECT_EQ(error(head + "[[block]]\nmin = [0, 1, 0]\nmax = [1, 1, 1]\n"),
            "a.toml:5:7: max: expected to be greater than min on every axis");
  for (const char* value : {"0", "-0.005", "nan", "\"wide\""})
    EXPECT_EQ(error(head + block + "spacing = " + value + '\n'), "a.toml:6:11: spacing: expected a number > 0, in m");
  for (const char* value : {"-0.1", "1.1", "nan"})
    EXPECT_EQ(error(head + block + "jitter = " + value + '\n'), "a.toml:6:10: jitter: expected a number from 0 to 1");
  EXPECT_EQ(error(head + block + "spacing = 0.05\n"), "a.toml:3:1: the block holds no particle, expected at least one");
}

TEST_F(SceneTest, RefusesWhatIsTooBig) {
  EXPECT_EQ(error(head + block + "spacing = 1e-9\n"), "a.toml:3:1: 3e+21 particles, expected at most 1073741824");
  EXPECT_EQ(error(head + block + "spacing = 1e-310\n"), "a.toml:3:1: inf particles, expected at most 1073741824");
  EXPECT_EQ(
      error("kind = \"fluid\"\nparticles_per_metre = 100000\n" + block),
      "a.toml:2:23: 100000 particles per metre cut the domain into 6.245412043e+11 cells, expected at most 2147483646");

  // 500,000,000 particles, which need 132 bytes each and 163.2 for lists of neighbours, while 1 GB of address space is
  // left.
  const Limit limit(RLIMIT_AS, address_space() + 1'000'000'000);
  const std::string message = error(head + block + "[[block]]\nmin = [0, 0, 0]\nmax = [1, 1, 0.5]\nspacing = 0.001\n");
  EXPECT_EQ(message.rfind("a.toml:6:1: simulating 500000024 particles in 4725 cells needs 155600 MB", 0), 0u)
      << message;
}

}  // namespace
}  // namespace lockstep::fluid
