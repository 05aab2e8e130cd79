// A bad scene of rigid bodies is refused in one line that says where and what was expected.
#include <gtest/gtest.h>

#include <string>

#include "tests/rigid_scenes.h"

namespace lockstep::rigid::worlds {
namespace {

TEST_F(RigidSceneTest, RefusesWhatIsNoScene) {
  EXPECT_EQ(error_of([&] { load_scene(path("none.toml")); }),
            path("none.toml") + ": cannot be read: No such file or directory");
  EXPECT_EQ(error_of([&] { load_scene(folder); }), folder + ": is a directory, expected a file");
  EXPECT_EQ(error("kind = rigid\n").rfind("a.toml:1:8: ", 0), 0u);
  EXPECT_EQ(error("kind = \"cloth\"\nframes = 1\n"), "a.toml:1:8: kind: expected \"rigid\"");
  EXPECT_EQ(error("kind = \"rigid\"\n" + ball), "a.toml:1:1: frames is missing");
  EXPECT_EQ(error(head), "a.toml:1:1: no body in it");
  EXPECT_EQ(error(head + "step = 1\n"),
            "a.toml:3:1: unknown key step, expected one of: kind, frames, rest, settle, time_step, iterations, "
            "gravity, friction, restitution, hull, body, pyramid, stack, wall, castle, dominoes, pit, soup");
  EXPECT_EQ(error(head + "[body]\nsphere = 1\n"), "a.toml:3:1: body: expected one or more tables [[body]]");
}

TEST_F(RigidSceneTest, RefusesWrongValues) {
  const auto with = [&](const std::string& line) { return error(head + line + '\n' + ball); };
  for (const char* value : {"0", "-1", "2", "nan", "inf", "\"1\""})
    EXPECT_EQ(with("time_step = " + std::string(value)),
              "a.toml:3:13: time_step: expected a number from 1e-6 to 1, in s")
        << value;
  for (const char* value : {"0", "1.5", "-1", "2147483648"})
    EXPECT_EQ(with("iterations = " + std::string(value)),
              "a.toml:3:14: iterations: expected a whole number from 1 to 2147483647");
  EXPECT_EQ(with("gravity = 9.81"), "a.toml:3:11: gravity: expected three finite numbers [x, y, z] in m/s^2");
  EXPECT_EQ(with("gravity = [0, nan, 0]"), "a.toml:3:15: gravity: expected three finite numbers [x, y, z] in m/s^2");
  EXPECT_EQ(with("gravity = [0, 2e6, 0]"), "a.toml:3:11: gravity: expected numbers of at most 1e6, in m/s^2");
  for (const char* value : {"-0.1", "101", "nan", "true"})
    EXPECT_EQ(with("friction = " + std::string(value)), "a.toml:3:12: friction: expected a number from 0 to 100");
  for (const char* value : {"-0.1", "1.1", "nan"})
    EXPECT_EQ(with("restitution = " + std::string(value)), "a.toml:3:15: restitution: expected a number from 0 to 1");
}

TEST_F(RigidSceneTest, RefusesWrongBodies) {
  const auto with = [&](const std::string& lines) { return error(head + "[[body]]\n" + lines); };
  const std::string length = "expected a number from 1e-4 to 1e5, in m";
  for (const char* value : {"0", "-1", "1e-5", "1e6", "nan", "\"1\"", "[1]"})
    EXPECT_EQ(with("sphere = " + std::string(value)), "a.toml:4:10: sphere: " + length);
  EXPECT_EQ(with("capsule = 1"), "a.toml:4:11: capsule: expected { half = ..., radius = ... }, in m");
  EXPECT_EQ(with("capsule = { half = 1 }"), "a.toml:4:11: radius is missing");
  EXPECT_EQ(with("capsule = { half = 0, radius = 1 }"), "a.toml:4:20: half: " + length);
  EXPECT_EQ(with("capsule = { half = 1, radius = 1, axis = 2 }"),
            "a.toml:4:35: unknown key axis, expected one of: half, radius");
  EXPECT_EQ(with("box = [1, -1, 1]"), "a.toml:4:7: box: expected three numbers from 1e-4 to 1e5, in m");
  EXPECT_EQ(with("box = [1, 1]"), "a.toml:4:7: box: expected three finite numbers [x, y, z] in m");
  EXPECT_EQ(with("hull = \"gem\""), "a.toml:4:8: hull: expected the name of a [[hull]]");
  EXPECT_EQ(with("hull = 3"), "a.toml:4:8: hull: expected text in quotes");
  EXPECT_EQ(with("plane = [0, 0, 0]"), "a.toml:4:9: plane: expected a normal that is not zero");
  EXPECT_EQ(with("plane = 1"), "a.toml:4:9: plane: expected three finite numbers [x, y, z] in any unit");
  EXPECT_EQ(with("mesh = 1"), "a.toml:4:8: mesh: expected text in quotes");
  EXPECT_EQ(with("mass = 1"), "a.toml:3:1: sphere, capsule, box, hull, plane, mesh or part is missing");
  EXPECT_EQ(with("sphere = 1\nbox = [1, 1, 1]"), "a.toml:5:7: box: expected one shape");
  EXPECT_EQ(with("sphere = 1\n[[body.part]]\nsphere = 1"), "a.toml:4:10: sphere: expected one shape");
  EXPECT_EQ(with("mass = 1\n[[body.part]]\nposition = [0, 0, 0]"),
            "a.toml:5:1: sphere, capsule, box, hull, plane or mesh is missing");
  EXPECT_EQ(
      with("[[body.part]]\nsphere = 1\nmass = 1"),
      "a.toml:6:1: unknown key mass, expected one of: sphere, capsule, box, hull, plane, mesh, position, orientation");
  EXPECT_EQ(with("colour = 1"),
            "a.toml:4:1: unknown key colour, expected one of: sphere, capsule, box, hull, plane, mesh, part, position, "
            "orientation, "
            "velocity, angular_velocity, mass, density, friction, restitution");

  const auto of = [&](const std::string& line) { return with("sphere = 1\n" + line); };
  EXPECT_EQ(of("position = [0, nan, 0]"), "a.toml:5:16: position: expected three finite numbers [x, y, z] in m");
  EXPECT_EQ(of("position = [0, 0, -2e6]"), "a.toml:5:12: position: expected numbers of at most 1e6, in m");
  const std::string unit = "orientation: expected a unit quaternion [x, y, z, w], its square 1 to within 0.001";
  for (const char* value :
       {"1", "[0, 0, 1]", "[0, 0, 0, 0]", "[0, 0, 0, 1.001]", "[0.5, 0.5, 0.5, 0.498]", "[0, 0, 0, 1e18]"})
    EXPECT_EQ(of("orientation = " + std::string(value)), "a.toml:5:15: " + unit) << value;
  EXPECT_EQ(of("orientation = [0, 0, nan, 1]"), "a.toml:5:22: " + unit);
  for (const char* value : {"0", "-1", "nan", "1e10", "\"1\""})
    EXPECT_EQ(of("mass = " + std::string(value)), "a.toml:5:8: mass: expected a number from 1e-6 to 1e9, in kg");
  for (const char* value : {"0", "-1", "nan", "1e7"})
    EXPECT_EQ(of("density = " + std::string(value)),
              "a.toml:5:11: density: expected a number from 1e-3 to 1e6, in kg/m^3");
  EXPECT_EQ(of("mass = 1\ndensity = 1"), "a.toml:6:11: density: expected either mass or density");
  EXPECT_EQ(of("velocity = [0, 1, 0]"),
            "a.toml:5:12: velocity: expected none of a body without mass or density, which never moves");
  EXPECT_EQ(of("mass = 1\nangular_velocity = [0, 1e7, 0]"),
            "a.toml:6:20: angular_velocity: expected numbers of at most 1e6, in rad/s");
  EXPECT_EQ(of("mass = 1\nfriction = -1"), "a.toml:6:12: friction: expected a number from 0 to 100");
  EXPECT_EQ(with("plane = [0, 1, 0]\nmass = 1"),
            "a.toml:5:8: mass: expected none of a body with a plane or a mesh, which never moves");
  EXPECT_EQ(with("mesh = \"a.obj\"\ndensity = 1"),
            "a.toml:5:11: density: expected none of a body with a plane or a mesh, which never moves");
  EXPECT_EQ(with("density = 1\n[[body.part]]\nplane = [0, 1, 0]"),
            "a.toml:4:11: density: expected none of a body with a plane or a mesh, which never moves");
  const std::string needle = "[[hull]]\nname = \"a\"\npoints = [[0, 0, 0], [1e-4, 0, 0], [0, 1e-9, 0], [0, 0, 1e-9]]\n";
  EXPECT_EQ(error(head + needle + "[[body]]\nhull = \"a\"\ndensity = 1e-3\n")
                .rfind("a.toml:6:1: a mass or an inertia of ", 0),
            0u);
}

TEST_F(RigidSceneTest, RefusesWrongHulls) {
  const auto with = [&](const std::string& lines) { return error(head + "[[hull]]\n" + lines + '\n' + ball); };
  EXPECT_EQ(with("points = [[0, 0, 0]]"), "a.toml:3:1: name is missing");
  EXPECT_EQ(with("name = \"a\""), "a.toml:3:1: points or file is missing");
  EXPECT_EQ(with("name = \"a\"\npoints = []\nfile = \"a.obj\""), "a.toml:6:8: file: expected either points or file");
  const auto of = [&](const std::string& points) { return with("name = \"a\"\npoints = " + points); };
  EXPECT_EQ(of("3"), "a.toml:5:10: points: expected an array of points [x, y, z], in m");
  EXPECT_EQ(of("[]"), "a.toml:5:10: points: 0 points, a hull has at least 4");
  EXPECT_EQ(of("[[0, 0, 0], [1, 0]]"), "a.toml:5:22: points: expected three numbers [x, y, z] from -1e5 to 1e5, in m");
  EXPECT_EQ(of("[[0, 0, 0], [1, 0, inf]]"),
            "a.toml:5:22: points: expected three numbers [x, y, z] from -1e5 to 1e5, in m");
  EXPECT_EQ(of("[[0, 0, 0], 1]"), "a.toml:5:22: points: expected three numbers [x, y, z] from -1e5 to 1e5, in m");
  EXPECT_EQ(of("[[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]"), "a.toml:5:10: points: the points are flat");
  EXPECT_EQ(of("[[1, 1, 1], [1, 1, 1], [1, 1, 1], [1, 1, 1]]"),
            "a.toml:5:10: points: expected points 1e-4 m apart, or more");
  EXPECT_EQ(of("[[5000, 0, 0], [5001, 0, 0], [5000, 1, 0], [5000, 0, 1]]"),
            "a.toml:5:10: points: expected points around the origin, not farther from it than 1000 times their extent");
  const std::string good = "[[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]";
  EXPECT_EQ(of(good + "\n[[hull]]\nname = \"a\"\npoints = " + good),
            "a.toml:7:8: name: expected another: there is a hull \"a\" above");
}

TEST_F(RigidSceneTest, RefusesWrongGenerators) {
  const auto with = [&](const std::string& lines) { return error(head + lines); };
  EXPECT_EQ(with("[[pyramid]]\n"), "a.toml:3:1: layers is missing");
  EXPECT_EQ(with("[[pyramid]]\nlayers = 0\n"), "a.toml:4:10: layers: expected a whole number from 1 to 67108864");
  EXPECT_EQ(with("[[pyramid]]\nlayers = 2\ncount = 1\n"),
            "a.toml:5:1: unknown key count, expected one of: layers, position, mass");
  EXPECT_EQ(with("[pyramid]\nlayers = 2\n"), "a.toml:3:1: pyramid: expected one or more tables [[pyramid]]");
  EXPECT_EQ(with("[[stack]]\ncount = 2\n"), "a.toml:3:1: box is missing");
  EXPECT_EQ(with("[[stack]]\ncount = 2\nbox = [0, 1, 1]\n"),
            "a.toml:5:7: box: expected three numbers from 1e-4 to 1e5, in m");
  EXPECT_EQ(with("[[wall]]\ncourses = 2\nbricks = 1.5\n"),
            "a.toml:5:10: bricks: expected a whole number from 1 to 67108864");
  EXPECT_EQ(with("[[castle]]\nbricks = 14\n"), "a.toml:4:10: bricks: expected a whole number from 15 to 67108864");
  EXPECT_EQ(with("[[castle]]\nmass = 0\n"), "a.toml:4:8: mass: expected a number from 1e-6 to 1e9, in kg");
  EXPECT_EQ(with("[[castle]]\nposition = [0, 1]\n"),
            "a.toml:4:12: position: expected three finite numbers [x, y, z] in m");
  EXPECT_EQ(with("[[dominoes]]\ncount = -1\n"), "a.toml:4:9: count: expected a whole number from 1 to 67108864");
  for (const char* value : {"\"sand\"", "1", "[\"boxes\"]"})
    EXPECT_EQ(with("[[pit]]\ncount = 1\nof = " + std::string(value)),
              "a.toml:5:6: of: expected \"boxes\", \"rounds\", \"hulls\" or \"mixed\"");
  EXPECT_EQ(with("[[pit]]\nof = \"boxes\"\n"), "a.toml:3:1: count is missing");
  EXPECT_EQ(with("[[pit]]\nof = \"boxes\"\ncount = 1\nacross = 0\n"),
            "a.toml:6:10: across: expected a whole number from 1 to 10000");
  EXPECT_EQ(with("[[pit]]\nof = \"boxes\"\ncount = 1\nfrom = 0\n"),
            "a.toml:6:8: from: expected a number from 1e-4 to 1e5, in m");
  EXPECT_EQ(with("[[pit]]\nof = \"boxes\"\ncount = 1\nseed = -1\n"),
            "a.toml:6:8: seed: expected a whole number from 0 to 9223372036854775807");
  for (const char* value : {"0", "1", "nan", "-0.5", "\"half\""})
    EXPECT_EQ(with("[[soup]]\nof = \"boxes\"\ncount = 1\noverlapping = " + std::string(value)),
              "a.toml:6:15: overlapping: expected a number from 1e-6 to 0.999");
}

TEST_F(RigidSceneTest, RefusesWhatIsTooBig) {
  EXPECT_EQ(error(head + "[[pyramid]]\nlayers = 1000000\n"),
            "a.toml:3:1: 3.333338333e+17 bodies, expected at most 67108864 in all");
  EXPECT_EQ(
      error(head + "[[dominoes]]\ncount = 60000000\n[[pit]]\nof = \"boxes\"\ncount = 67108864\n").rfind("a.toml:", 0),
      0u);
  const Limit limit(RLIMIT_AS, address_space() + 500'000'000);
  const std::string message = error(head + "[[dominoes]]\ncount = 10000000\n");
  EXPECT_EQ(message.rfind("a.toml:3:1: 10000000 bodies needs ", 0), 0u) << message;
}

}  // namespace
}  // namespace lockstep::rigid::worlds
