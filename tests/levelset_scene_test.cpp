// Scenes of the level set: those of the repository load, and a bad one is refused in one line that says where.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>

#include "common/levelset/scene.h"
#include "common/levelset/shapes.h"
#include "tests/levelset_fields.h"
#include "tests/temporary_folder.h"
#include "verify/domain.h"

namespace lockstep::levelset {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

struct LevelsetSceneTest : TemporaryFolder {
  Scene load(const std::string& toml) const {
    write_bytes(path("a.toml"), toml);
    return load_scene(path("a.toml"));
  }
  // The message without the folder: "a.toml:line:column: ...".
  std::string error(const std::string& toml) const {
    const std::string message = error_of([&] { load(toml); });
    EXPECT_EQ(message.rfind(folder, 0), 0u) << message;
    return message.substr(std::min(message.size(), folder.size() + 1));
  }
};

const std::string head = "kind = \"levelset\"\npoints = [10, 12, 14]\n";
const std::string sphere = "[[sphere]]\ncentre = [0.5, 0.6, 0.7]\nradius = 0.25\n";
const std::string mesh = "[mesh]\nfile = \"a.obj\"\n", unit_box = "spacing = 0.1\norigin = [0, 0, 0]\n";

// Points 1 2 3 4 of a tetrahedron, and its faces.
const std::string corners = "v 0.1 0.1 0.1\nv 0.9 0.1 0.1\nv 0.1 0.9 0.1\nv 0.1 0.1 0.9\n";
const std::string faces = "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

// --- Scenes. Run from the root of the repository, as `make test` does.

TEST(LevelsetScenes, OfTheRepositoryLoad) {
  struct Expected {
    int nx;
    bool has_band;
    bool operator==(const Expected&) const = default;
  };
  const std::map<std::string, Expected> expected{
      {"spheres_and_box_64", {64, true}},
      {"spheres_and_box_128", {128, true}},
      {"spheres_and_box_256", {256, true}},
      {"spheres_and_box_64_full", {64, false}},
      {"spheres_and_box_128_full", {128, false}},
      {"spheres_and_box_256_full", {256, false}},
      {"spheres_64", {64, false}},
      {"spheres_128", {128, false}},
      {"spheres_256", {256, false}},
      {"torus_128", {128, true}},
      {"corrupted_64", {64, true}},
      {"corrupted_256", {256, true}},
      {"mesh_96", {96, true}},
      {"slab_33", {33, true}},
      {"slab_on_points", {33, true}},
  };
  std::map<std::string, Expected> found;
  for (const auto& file : std::filesystem::directory_iterator("scenes/levelset")) {
    if (file.path().extension() != ".toml") continue;
    EXPECT_EQ(verify::domain_of_scene(file.path().string()).name, "levelset");
    if (file.path().stem().string().starts_with("spheres_and_box_512")) continue;  // a gigabyte each
    const Scene scene = load_scene(file.path().string());
    found[scene.name] = {scene.phi.nx, std::isfinite(scene.band)};
    EXPECT_EQ(scene.shapes.empty(), scene.name == "mesh_96");
  }
  EXPECT_EQ(found, expected);
}

TEST_F(LevelsetSceneTest, KnotIsWhatItsScriptWrites) {
  if (std::system("python3 -c '' 2>/dev/null") != 0) GTEST_SKIP() << "no python3";
  std::filesystem::copy_file("scenes/levelset/knot.py", path("knot.py"));
  ASSERT_EQ(std::system(("python3 " + path("knot.py")).c_str()), 0);
  EXPECT_TRUE(read_bytes(path("knot.obj")) == read_bytes("scenes/levelset/knot.obj"));
  EXPECT_LT(std::filesystem::file_size(path("knot.obj")), 150'000u);
}

TEST_F(LevelsetSceneTest, SaysWhatItSays) {
  const Scene scene = load(
      "kind = \"levelset\"\npoints = [6, 7, 9]\nspacing = 0.25\norigin = [1, -2, 3]\nband = 2.5\nrounds = 4\n"
      "[[sphere]]\ncentre = [2, -1.5, 4]\nradius = 0.3\n"
      "[[box]]\ncentre = [20, 2, 3]\nhalf = [4, 5, 6]\n[[torus]]\ncentre = [3, 2, 1]\nring = 2\ntube = 0.5\n");
  EXPECT_EQ(scene.name, "a");
  EXPECT_EQ(scene.path, path("a.toml"));
  EXPECT_EQ(scene.band, .625);
  EXPECT_EQ(scene.rounds, 4);
  EXPECT_EQ(scene.phi.nx, 6);
  EXPECT_EQ(scene.phi.ny, 7);
  EXPECT_EQ(scene.phi.nz, 9);
  EXPECT_EQ(scene.phi.spacing, .25f);
  const Vector3<double> p = scene.grid.position(1, 2, 3);
  EXPECT_EQ(p.x, 1.375);
  EXPECT_EQ(p.y, -1.375);
  EXPECT_EQ(p.z, 3.875);
  ASSERT_EQ(scene.shapes.size(), 3u);
  EXPECT_EQ(std::get<Sphere>(scene.shapes[0]).radius, .3);
  EXPECT_EQ(std::get<Box>(scene.shapes[1]).half.z, 6);
  EXPECT_EQ(std::get<Torus>(scene.shapes[2]).ring, 2);
  EXPECT_EQ(std::get<Torus>(scene.shapes[2]).tube, .5);
  for_each_point(scene.phi, [&](int x, int y, int z) {
    EXPECT_EQ(scene.phi(x, y, z), static_cast<float>(signed_distance(scene.shapes, scene.grid.position(x, y, z))));
  });
}

TEST_F(LevelsetSceneTest, HasDefaults) {
  const Scene scene = load(head + sphere);
  EXPECT_EQ(scene.grid.spacing, .1);
  EXPECT_EQ(scene.grid.origin.x, 0);
  EXPECT_EQ(scene.band, infinity);
  EXPECT_EQ(scene.rounds, 1);
}

TEST_F(LevelsetSceneTest, DistortsAllButTheSign) {
  const Scene plain = load(head + sphere), scene = load(head + "distort = 0.9\n" + sphere);
  float least = 1, greatest = 1;
  for_each_point(scene.phi, [&](int i, int j, int k) {
    const auto [x, y, z] = scene.grid.position(i, j, k);
    const float ratio = scene.phi(i, j, k) / plain.phi(i, j, k);
    EXPECT_NEAR(ratio, 1 + .9 * std::sin(9 * x) * std::cos(7 * y) * std::sin(8 * z + 1), 1e-5);
    least = std::min(least, ratio), greatest = std::max(greatest, ratio);
  });
  EXPECT_LT(least, .5f);
  EXPECT_GT(greatest, 1.5f);
}

TEST_F(LevelsetSceneTest, TakesAMesh) {
  write_bytes(path("a.obj"), corners + faces);
  const Scene scene = load(head + unit_box + "distort = 0.5\n" + mesh),
              twice = load(head + "spacing = 0.2\n" + mesh + "scale = 2\n");
  EXPECT_TRUE(scene.shapes.empty());
  EXPECT_LT(scene.phi(1, 1, 1), 0);
  EXPECT_GT(scene.phi(9, 9, 9), 0);
  const double distorted = 1 + .5 * std::sin(9 * .15) * std::cos(7 * .15) * std::sin(8 * .15 + 1);
  EXPECT_NEAR(scene.phi(1, 1, 1), -.05 * distorted, 1e-8);
  EXPECT_NEAR(twice.phi(1, 1, 1), -.1, 1e-8);
}

// A tetrahedron far from the unit box: all of it is in the grid, and nowhere on the grid's sides is within the band.
TEST_F(LevelsetSceneTest, FitsTheGridToAMesh) {
  write_bytes(path("a.obj"), "v 100 -7 3\nv 103 -7 3\nv 100 -5 3\nv 100 -7 4\n" + faces);
  for (const std::string& band : {std::string("band = 2\n"), std::string()}) {
    const Scene scene = load("kind = \"levelset\"\npoints = [30, 32, 34]\n" + band + mesh);
    const double room = band.empty() ? 4 : 3;
    EXPECT_DOUBLE_EQ(scene.grid.spacing, 3 / (30 - 2 * room));
    EXPECT_DOUBLE_EQ(scene.grid.origin.x, 101.5 - 15 * scene.grid.spacing);
    EXPECT_DOUBLE_EQ(scene.grid.origin.y, -6 - 16 * scene.grid.spacing);
    EXPECT_DOUBLE_EQ(scene.grid.origin.z, 3.5 - 17 * scene.grid.spacing);
    double least = infinity;
    for_each_point(scene.phi, [&](int x, int y, int z) {
      const bool on_a_side = x == 0 || y == 0 || z == 0 || x == 29 || y == 31 || z == 33;
      if (on_a_side) least = std::min<double>(least, scene.phi(x, y, z));
    });
    EXPECT_GT(least, band.empty() ? 2.9 * scene.grid.spacing : scene.band);
  }
  // Where one key is given, the other is as for shapes.
  write_bytes(path("a.obj"), corners + faces);
  EXPECT_EQ(load(head + "spacing = 0.2\n" + mesh).grid.origin.x, 0);
  EXPECT_EQ(load(head + "origin = [0.05, 0.05, 0.05]\n" + mesh).grid.spacing, .1);
}

TEST_F(LevelsetSceneTest, RefusesAMeshBeyondTheGrid) {
  write_bytes(path("a.obj"), corners + faces);
  const std::string hint = ", in m; without spacing and origin the grid fits the mesh";
  EXPECT_EQ(
      error(head + unit_box + mesh + "scale = 1.2\n"),
      "a.toml:5:1: the mesh, from (0.12, 0.12, 0.12) to (1.08, 1.08, 1.08), reaches beyond the grid, from (0, 0, 0) to "
      "(1, 1.2, 1.4)" +
          hint);
  EXPECT_EQ(error(head + "origin = [2, 0, 0]\n" + mesh),
            "a.toml:4:1: the mesh, from (0.1, 0.1, 0.1) to (0.9, 0.9, 0.9), reaches beyond the grid, from (2, 0, 0) to "
            "(3, 1.2, 1.4)" +
                hint);
  EXPECT_EQ(error(head + "band = 4\n" + mesh),
            "a.toml:2:10: points: expected more than 10 points along each axis, for the mesh and 5 spacings around it");
  EXPECT_EQ(
      error(head + mesh + "scale = 1e-7\n"),
      "a.toml:2:10: points: a spacing of 4e-08 m fits the mesh, which reaches from (1e-08, 1e-08, 1e-08) to (9e-08, "
      "9e-08, 9e-08); expected 1e-6 to 1e6, and coordinates of at most 1e9 spacings");
}

TEST_F(LevelsetSceneTest, RefusesWhatIsNoScene) {
  EXPECT_EQ(error_of([&] { load_scene(path("none.toml")); }),
            path("none.toml") + ": cannot be read: No such file or directory");
  EXPECT_EQ(error_of([&] { load_scene(folder); }), folder + ": is a directory, expected a file");
  EXPECT_EQ(error("kind = levelset\n").rfind("a.toml:1:8: ", 0), 0u);
  EXPECT_EQ(error("kind = \"cloth\"\npoints = [2, 2, 2]\n"), "a.toml:1:8: kind: expected \"levelset\"");
  EXPECT_EQ(error(sphere), "a.toml:1:1: kind is missing");
  EXPECT_EQ(error("kind = \"levelset\"\n" + sphere), "a.toml:1:1: points is missing");
  EXPECT_EQ(error(head), "a.toml:1:1: sphere, box, torus or mesh is missing");
  EXPECT_EQ(error(head + sphere + mesh), "a.toml:6:1: mesh: expected either shapes or [mesh]");
  EXPECT_EQ(error(head + "bandwidth = 3\n" + sphere),
            "a.toml:3:1: unknown key bandwidth, expected one of: kind, points, spacing, origin, band, rounds, distort, "
            "sphere, box, torus, mesh");
}

TEST_F(LevelsetSceneTest, RefusesWrongGrids) {
  const auto with = [&](const std::string& points) {
    return error("kind = \"levelset\"\npoints = " + points + '\n' + sphere);
  };
  const std::string expected = "points: expected three whole numbers [x, y, z] from 2 to 2147483647";
  for (const char* points : {"64", "[64, 64]", "[2, 2, 2, 2]", "\"64\"", "[]"})
    EXPECT_EQ(with(points), "a.toml:2:10: " + expected) << points;
  for (const char* n : {"1", "0", "-3", "2.0", "nan", "2147483648", "\"2\""})
    EXPECT_EQ(with("[2, " + std::string(n) + ", 2]"), "a.toml:2:14: " + expected);

  const auto line = [&](const std::string& line) { return error(head + line + '\n' + sphere); };
  for (const char* value : {"0", "-0.1", "nan", "inf", "1e-7", "1e7", "\"1\"", "true"})
    EXPECT_EQ(line("spacing = " + std::string(value)),
              "a.toml:3:11: spacing: expected a number from 1e-6 to 1e6, in m");
  EXPECT_EQ(line("origin = 0"), "a.toml:3:10: origin: expected three finite numbers [x, y, z] in m");
  EXPECT_EQ(line("origin = [0, nan, 0]"), "a.toml:3:14: origin: expected three finite numbers [x, y, z] in m");
  EXPECT_EQ(line("origin = [0, 0, 2e8]"), "a.toml:3:10: origin: expected numbers of at most 1e9 spacings");
}

TEST_F(LevelsetSceneTest, RefusesWrongValues) {
  const auto with = [&](const std::string& line) { return error(head + line + '\n' + sphere); };
  for (const char* value : {"0", "-5", "nan", "inf", "19.27", "\"5\""})
    EXPECT_EQ(with("band = " + std::string(value)),
              "a.toml:3:8: band: expected a number from 1e-9 to 19.26136028, the diagonal of the grid, in spacings")
        << value;
  for (const char* value : {"0", "-1", "1.5", "2147483648"})
    EXPECT_EQ(with("rounds = " + std::string(value)),
              "a.toml:3:10: rounds: expected a whole number from 1 to 2147483647");
  for (const char* value : {"-0.1", "0.91", "nan", "inf", "\"0\""})
    EXPECT_EQ(with("distort = " + std::string(value)), "a.toml:3:11: distort: expected a number from 0 to 0.9");
}

TEST_F(LevelsetSceneTest, RefusesWrongShapes) {
  EXPECT_EQ(error(head + "[sphere]\ncentre = [0, 0, 0]\nradius = 1\n"),
            "a.toml:3:1: sphere: expected one or more tables [[sphere]]");
  EXPECT_EQ(error(head + "[[sphere]]\ncentre = [0, 0, 0]\n"), "a.toml:3:1: radius is missing");
  EXPECT_EQ(error(head + "[[sphere]]\ncentre = [0, 0, 0]\nradius = 1\ncolour = 1\n"),
            "a.toml:6:1: unknown key colour, expected one of: centre, radius");
  EXPECT_EQ(error(head + "[[sphere]]\ncentre = [0, inf, 0]\nradius = 1\n"),
            "a.toml:4:14: centre: expected three finite numbers [x, y, z] in m");
  EXPECT_EQ(error(head + "[[box]]\ncentre = [0, 0, 0]\nhalf = [1, 0, 1]\n"),
            "a.toml:5:8: half: expected three numbers from 1e-9 to 1e9, in m");
  for (const char* value : {"0", "-1", "nan", "inf", "1e10"}) {
    EXPECT_EQ(error(head + "[[sphere]]\ncentre = [0, 0, 0]\nradius = " + value + '\n'),
              "a.toml:5:10: radius: expected a number from 1e-9 to 1e9, in m");
    EXPECT_EQ(error(head + "[[torus]]\ncentre = [0, 0, 0]\nring = " + value + "\ntube = 1\n"),
              "a.toml:5:8: ring: expected a number from 1e-9 to 1e9, in m");
    EXPECT_EQ(error(head + "[[torus]]\ncentre = [0, 0, 0]\nring = 1\ntube = " + value + '\n'),
              "a.toml:6:8: tube: expected a number from 1e-9 to 1e9, in m");
  }
  EXPECT_EQ(error(head + "[[torus]]\ncentre = [0, 0, 0]\nring = 1\ntube = 1\n"),
            "a.toml:6:8: tube: expected less than the ring's radius");
}

TEST_F(LevelsetSceneTest, RefusesWhatHasNoInterface) {
  const auto of = [&](const std::string& centre, const std::string& radius) {
    return error(head + "[[sphere]]\ncentre = " + centre + "\nradius = " + radius + '\n');
  };
  EXPECT_EQ(of("[5, 5, 5]", "1"), "a.toml:1:1: no interface: all points are outside");
  EXPECT_EQ(of("[0.5, 0.5, 0.5]", "0.01"), "a.toml:1:1: no interface: all points are outside") << "between the points";
  EXPECT_EQ(of("[0.5, 0.5, 0.5]", "9"), "a.toml:1:1: no interface: all points are inside");
}

TEST_F(LevelsetSceneTest, TakesAnInterfaceThatOnePointIsOn) {
  const Scene scene = load(
      "kind = \"levelset\"\npoints = [3, 3, 3]\nspacing = 1\norigin = [-0.5, -0.5, -0.5]\n[[sphere]]\ncentre = [1.5, "
      "1, 1]\nradius = "
      "0.5\n");
  EXPECT_EQ(scene.phi(1, 1, 1), 0);
  EXPECT_EQ(scene.phi(2, 1, 1), 0);
  EXPECT_EQ(std::ranges::count_if(scene.phi.value, [](float phi) { return phi < 0; }), 0);
}

TEST_F(LevelsetSceneTest, RefusesWhatIsTooBig) {
  const auto of = [&](const std::string& points) {
    return error("kind = \"levelset\"\npoints = " + points + '\n' + sphere);
  };
  EXPECT_EQ(of("[2147483647, 2147483647, 2147483647]"),
            "a.toml:2:10: points: expected at most 2147483647 with padding, not 9.9035206e+27");
  EXPECT_EQ(of("[2, 65536, 65536]"),
            "a.toml:2:10: points: expected at most 2147483647 with padding, not 3.435973837e+11");
  const Limit limit(RLIMIT_AS, address_space() + 500'000'000);
  const std::string message = of("[256, 256, 256]");
  EXPECT_EQ(message.rfind("a.toml:2:10: a grid of 16777216 points needs 838.861 MB of memory, and ", 0), 0u) << message;
}

TEST_F(LevelsetSceneTest, RefusesWrongMeshes) {
  EXPECT_EQ(error(head + mesh), "a.obj: cannot be read: No such file or directory");
  EXPECT_EQ(error(head + "[mesh]\nscale = 1\n"), "a.toml:3:1: file is missing");
  EXPECT_EQ(error(head + "[mesh]\nfile = 1\n"), "a.toml:4:8: file: expected text in quotes");
  EXPECT_EQ(error(head + mesh + "scale = 0\n"), "a.toml:5:9: scale: expected a number from 1e-9 to 1e9");
  EXPECT_EQ(error(head + mesh + "mass = 1\n"), "a.toml:5:1: unknown key mass, expected one of: file, scale");

  const auto of = [&](const std::string& obj) {
    write_bytes(path("a.obj"), obj);
    return error(head + mesh);
  };
  EXPECT_EQ(of(corners + "f 1 2 9\n"), "a.obj:5: f: point 9 of 4");
  EXPECT_EQ(of(corners + "f 1 3 2\nf 1 2 4\nf 1 4 3\n"),
            "a.obj: the edge of points 2 and 3 is in 1 triangle, expected two: a closed mesh");
  EXPECT_EQ(of(corners + "v 1 1 1\n" + faces + "f 1 2 5\n"),
            "a.obj: the edge of points 1 and 2 is in 3 triangles, expected two: a closed mesh");
  write_bytes(path("a.obj"), corners + faces);
  EXPECT_EQ(error(head + "spacing = 1\n" + mesh + "scale = 1e-3\n"), "a.toml:1:1: no interface: all points are outside")
      << "all beyond its corners";
}

}  // namespace
}  // namespace lockstep::levelset
