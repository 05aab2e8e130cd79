// A bad scene of cloth is refused in one line that says where and what was expected.
#include <gtest/gtest.h>

#include <string>

#include "tests/cloth_scenes.h"

namespace lockstep::cloth {
namespace {

TEST_F(ClothSceneTest, RefusesWhatIsNoScene) {
  EXPECT_EQ(error_of([&] { load_scene(path("none.toml")); }),
            path("none.toml") + ": cannot be read: No such file or directory");
  EXPECT_EQ(error_of([&] { load_scene(folder); }), folder + ": is a directory, expected a file");
  EXPECT_EQ(error("kind = cloth\n").rfind("a.toml:1:8: ", 0), 0u);
  EXPECT_EQ(error("kind = \"fluid\"\n" + sheet), "a.toml:1:8: kind: expected \"cloth\"");
  EXPECT_EQ(error(sheet), "a.toml:1:1: kind is missing");
  EXPECT_EQ(error(head), "a.toml:1:1: sheet or mesh is missing");
  EXPECT_EQ(error(head + "sheet = 1\n"), "a.toml:2:9: sheet: expected one or more tables [[sheet]]");
  EXPECT_EQ(error(head + sheet + "copies = 0\n"), "a.toml:9:10: copies: expected a whole number from 1 to 2147483647");
}

TEST_F(ClothSceneTest, RefusesUnknownAndMissingKeys) {
  EXPECT_EQ(error(head + "frmes = 3\n" + sheet),
            "a.toml:2:1: unknown key frmes, expected one of: kind, frames, time_step, substeps, iterations, gravity, "
            "wind, drag, damping, "
            "friction, thickness, sheet, mesh, plane, sphere, capsule, box");
  EXPECT_EQ(error(head + sheet + "bend = true\n"),
            "a.toml:9:1: unknown key bend, expected one of: rows, columns, origin, width, height, mass, bending, pins, "
            "pull, copies, "
            "shift");
  EXPECT_EQ(error(head + "[sheet]\nrows = 1\n"), "a.toml:2:1: columns is missing");
  EXPECT_EQ(error(head + mesh + "bend = true\n"),
            "a.toml:5:1: unknown key bend, expected one of: file, mass, scale, bending, pins_above, copies, shift");
  EXPECT_EQ(error(head + "[mesh]\nmass = 1\n"), "a.toml:2:1: file is missing");
  EXPECT_EQ(error(head + "[mesh]\nfile = \"a.obj\"\n"), "a.toml:2:1: mass is missing");
  EXPECT_EQ(error(head + sheet + "pull = { edge = \"top\" }\n"), "a.toml:9:8: by is missing");
  EXPECT_EQ(error(head + sheet + "[[sphere]]\ncentre = [0, 0, 0]\n"), "a.toml:9:1: radius is missing");
  EXPECT_EQ(error(head + sheet + "[[box]]\nsize = 1\n"),
            "a.toml:10:1: unknown key size, expected one of: centre, half, turn");
}

TEST_F(ClothSceneTest, RefusesWrongValues) {
  const auto with = [&](const std::string& line) { return error(head + line + '\n' + sheet); };
  for (const char* value : {"0", "-1", "1e-7", "2", "nan", "inf", "\"1\"", "true"})
    EXPECT_EQ(with("time_step = " + std::string(value)),
              "a.toml:2:13: time_step: expected a number from 1e-6 to 1, in s");
  for (const char* value : {"0", "-1", "1.0", "2147483648", "\"1\""})
    EXPECT_EQ(with("frames = " + std::string(value)),
              "a.toml:2:10: frames: expected a whole number from 1 to 2147483647");
  EXPECT_EQ(with("substeps = 0"), "a.toml:2:12: substeps: expected a whole number from 1 to 1000000");
  EXPECT_EQ(with("iterations = -1"), "a.toml:2:14: iterations: expected a whole number from 0 to 2147483647");
  EXPECT_EQ(with("gravity = -9.81"), "a.toml:2:11: gravity: expected three finite numbers [x, y, z] in m/s^2");
  EXPECT_EQ(with("wind = [0, nan, 0]"), "a.toml:2:12: wind: expected three finite numbers [x, y, z] in m/s");
  for (const char* value : {"-1", "nan", "inf", "1e10", "\"1\""}) {
    EXPECT_EQ(with("drag = " + std::string(value)), "a.toml:2:8: drag: expected a number from 0 to 1e9, in kg/m^3");
    EXPECT_EQ(with("damping = " + std::string(value)), "a.toml:2:11: damping: expected a number from 0 to 1e9, in 1/s");
    EXPECT_EQ(with("friction = " + std::string(value)), "a.toml:2:12: friction: expected a number from 0 to 1e9");
    EXPECT_EQ(with("thickness = " + std::string(value)),
              "a.toml:2:13: thickness: expected a number from 0 to 1e9, in m");
  }
}

TEST_F(ClothSceneTest, RefusesWrongSheets) {
  // A sheet with one of its lines replaced.
  const auto with = [&](const std::string& line) {
    const std::string key = line.substr(0, line.find(' '));
    const std::size_t begin = sheet.find('\n' + key + " = ") + 1;
    return error(head + std::string(sheet).replace(begin, sheet.find('\n', begin) - begin, line));
  };
  for (const char* value : {"0", "-1", "2.5", "2147483648"})
    EXPECT_EQ(with("rows = " + std::string(value)), "a.toml:3:8: rows: expected a whole number from 1 to 2147483647");
  EXPECT_EQ(with("columns = 0"), "a.toml:4:11: columns: expected a whole number from 1 to 2147483647");
  for (const char* value : {"0", "-0.3", "nan", "inf", "1e-10", "1e10", "\"light\""})
    EXPECT_EQ(with("mass = " + std::string(value)), "a.toml:8:8: mass: expected a number from 1e-9 to 1e9, in kg");
  EXPECT_EQ(with("origin = [0, 0]"), "a.toml:5:10: origin: expected three finite numbers [x, y, z] in m");

  const auto apart = [](const std::string& a, const std::string& b, const std::string& metres) {
    return "a.toml:2:1: particles " + a + " and " + b + " are tied and " + metres +
           " m apart, expected from 1e-09 to 1000000000";
  };
  EXPECT_EQ(with("width = [0, 0, 0]"), apart("[0, 0]", "[0, 1]", "0"));
  EXPECT_EQ(with("width = [1e-30, 0, 0]"), apart("[0, 0]", "[0, 1]", "2.5e-31"));
  EXPECT_EQ(with("width = [4e18, 0, 0]").rfind("a.toml:6:10: width: ", 0), 0u);
  EXPECT_EQ(with("width = [4e17, 0, 0]"), apart("[0, 0]", "[0, 1]", "1e+17"));
  EXPECT_EQ(with("height = [0, 0, 0]"), apart("[0, 0]", "[1, 0]", "0"));
  EXPECT_EQ(with("height = [2, 0, 0]"), apart("[0, 1]", "[1, 0]", "0")) << "along the width";
  EXPECT_EQ(
      error(head +
            "[sheet]\nrows = 1\ncolumns = 1\norigin = [0, 0, 0]\nwidth = [0, 0, 0]\nheight = [0, 0, 0]\nmass = 1\n"),
      "a.toml:2:1: a sheet of one particle, expected at least two");
}

TEST_F(ClothSceneTest, RefusesWrongPins) {
  const auto with = [&](const std::string& pins) { return error(head + sheet + "pins = " + pins + '\n'); };
  EXPECT_EQ(with("\"top\""), "a.toml:9:8: pins: expected a list of edges, corners and particles [row, column]");
  for (const char* pin : {"\"middle\"", "\"\"", "1", "[3, 0]", "[0, 5]", "[-1, 0]", "[0, -1]", "[0.0, 0]", "[0]",
                          "[0, 0, 0]", "[[0, 0]]"})
    EXPECT_EQ(with("[\"top\", " + std::string(pin) + ']'),
              "a.toml:9:16: pins: expected an edge (\"top\", \"bottom\", \"left\", \"right\"), a corner (\"top_left\", "
              "...) or [row, column] of "
              "a particle, [0, 0] to [2, 4]")
        << pin;

  const auto pull = [&](const std::string& value) { return error(head + sheet + "pull = " + value + '\n'); };
  EXPECT_EQ(pull("\"right\""), "a.toml:9:8: pull: expected { edge = ..., by = [x, y, z] }");
  for (const char* edge : {"\"top_left\"", "\"\"", "\"north\""})
    EXPECT_EQ(pull("{ edge = " + std::string(edge) + ", by = [1, 0, 0] }"),
              "a.toml:9:17: edge: expected \"top\", \"bottom\", \"left\" or \"right\"");
  EXPECT_EQ(pull("{ edge = 1, by = [1, 0, 0] }"), "a.toml:9:17: edge: expected text in quotes");
  EXPECT_EQ(pull("{ edge = \"top\", by = [inf, 0, 0] }"),
            "a.toml:9:30: by: expected three finite numbers [x, y, z] in m");
}

TEST_F(ClothSceneTest, RefusesWrongBodies) {
  const auto with = [&](const std::string& body) { return error(head + sheet + body); };
  EXPECT_EQ(with("[sphere]\ncentre = [0, 0, 0]\nradius = 1\n"),
            "a.toml:9:1: sphere: expected one or more tables [[sphere]]");
  EXPECT_EQ(error(head + "box = [1]\n" + sheet), "a.toml:2:8: box: expected a table [[box]]");
  EXPECT_EQ(with("[[plane]]\nnormal = [0, 0, 0]\npoint = [0, 0, 0]\n"),
            "a.toml:10:10: normal: expected a direction, not zero");
  EXPECT_EQ(with("[[plane]]\nnormal = [0, nan, 0]\npoint = [0, 0, 0]\n"),
            "a.toml:10:14: normal: expected three finite numbers [x, y, z] in any unit");
  for (const char* radius : {"0", "-1", "nan", "inf"}) {
    EXPECT_EQ(with("[[sphere]]\ncentre = [0, 0, 0]\nradius = " + std::string(radius) + '\n'),
              "a.toml:11:10: radius: expected a number from 1e-9 to 1e9, in m");
    EXPECT_EQ(with("[[capsule]]\nfrom = [0, 0, 0]\nto = [0, 0, 0]\nradius = " + std::string(radius) + '\n'),
              "a.toml:12:10: radius: expected a number from 1e-9 to 1e9, in m");
  }
  EXPECT_EQ(with("[[box]]\ncentre = [0, 0, 0]\nhalf = [1, 0, 1]\n"),
            "a.toml:11:8: half: expected three numbers from 1e-9 to 1e9, in m");
  EXPECT_EQ(with("[[box]]\ncentre = [0, 0, 0]\nhalf = [1, 1, 1]\nturn = 30\n"),
            "a.toml:12:8: turn: expected three finite numbers [x, y, z] in degrees");
}

TEST_F(ClothSceneTest, RefusesWhatIsTooBig) {
  const auto sheet_of = [](const std::string& rows, const std::string& columns) {
    return head + "[sheet]\nrows = " + rows + "\ncolumns = " + columns +
           "\norigin = [0, 0, 0]\nwidth = [1, 0, 0]\nheight = [0, 1, 0]\nmass = 1\n";
  };
  EXPECT_EQ(error(sheet_of("2147483647", "2147483647")),
            "a.toml:2:1: 4.611686016e+18 particles, with rows filled up to whole vectors, expected at most 268435456");
  EXPECT_EQ(error(sheet_of("16777217", "1")),
            "a.toml:2:1: 268435472 particles, with rows filled up to whole vectors, expected at most 268435456");
  const Limit limit(RLIMIT_AS, address_space() + 1'000'000'000);
  const std::string message = error(sheet_of("4000", "4000"));
  EXPECT_EQ(message.rfind("a.toml:2:1: a sheet of 16000000 particles needs ", 0), 0u) << message;
}

TEST_F(ClothSceneTest, RefusesWhatIsNoMesh) {
  EXPECT_EQ(error(head + mesh), "a.obj: cannot be read: No such file or directory");
  EXPECT_EQ(error(head + "[mesh]\nfile = \"\"\nmass = 1\n"), ": expected a file .obj, .off, .ply or .stl");
  EXPECT_EQ(error(head + "[mesh]\nfile = 1\nmass = 1\n"), "a.toml:3:8: file: expected text in quotes");
  EXPECT_EQ(error(head + "[mesh]\nfile = \"a.obj\"\nmass = -1\n"),
            "a.toml:4:8: mass: expected a number from 1e-9 to 1e9, in kg");
  EXPECT_EQ(error(head + mesh + "scale = 0\n"), "a.toml:5:9: scale: expected a number from 1e-9 to 1e9");
  EXPECT_EQ(error(head + mesh + "pins_above = nan\n"), "a.toml:5:14: pins_above: expected a finite number, in m");
}

TEST_F(ClothSceneTest, RefusesTiedPointsAtOnePlace) {
  write_bytes(path("a.obj"), square + "v 1 1 0\nf 1 2 3\nf 1 3 4\nf 3 4 5\n");
  EXPECT_EQ(error(head + mesh), "a.obj: particles 5 and 3 are tied and 0 m apart, expected from 1e-09 to 1000000000");
  EXPECT_EQ(load(head + mesh + "pins_above = 0.5\n").cloth.constraints.count, 4) << "the two are pinned, and not tied";
}

}  // namespace
}  // namespace lockstep::cloth
