// Scenes of the level set, shapes, meshes, where distances begin, and images: those of the repository load, a bad one is refused in one
// line that says where, and distances are those of closed forms.
#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <map>
#include <random>

#include "common/levelset/initialize.h"
#include "common/levelset/mesh.h"
#include "common/levelset/scene.h"
#include "common/levelset/shapes.h"
#include "common/levelset/vti.h"
#include "common/obj.h"
#include "verify/domain.h"
#include "tests/temporary_folder.h"

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
const std::string mesh = "[mesh]\nfile = \"a.obj\"\n";

// Points 1 2 3 4 of a tetrahedron, and its faces.
const std::string corners = "v 0.1 0.1 0.1\nv 0.9 0.1 0.1\nv 0.1 0.9 0.1\nv 0.1 0.1 0.9\n";
const std::string faces = "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

// All points of a grid, in the order of the field.
template <class Action>
void for_each_point(const auto& grid, Action action) {
  for (int z = 0; z < grid.nz; ++z)
    for (int y = 0; y < grid.ny; ++y)
      for (int x = 0; x < grid.nx; ++x) action(x, y, z);
}

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
  const Scene scene = load(head + "distort = 0.5\n" + mesh), twice = load(head + "spacing = 0.2\n" + mesh + "scale = 2\n");
  EXPECT_TRUE(scene.shapes.empty());
  EXPECT_LT(scene.phi(1, 1, 1), 0);
  EXPECT_GT(scene.phi(9, 9, 9), 0);
  const double distorted = 1 + .5 * std::sin(9 * .15) * std::cos(7 * .15) * std::sin(8 * .15 + 1);
  EXPECT_NEAR(scene.phi(1, 1, 1), -.05 * distorted, 1e-8);
  EXPECT_NEAR(twice.phi(1, 1, 1), -.1, 1e-8);
}

TEST_F(LevelsetSceneTest, RefusesWhatIsNoScene) {
  EXPECT_EQ(error_of([&] { load_scene(path("none.toml")); }), path("none.toml") + ": cannot be read: No such file or directory");
  EXPECT_EQ(error_of([&] { load_scene(folder); }), folder + ": is a directory, expected a file");
  EXPECT_EQ(error("kind = levelset\n").rfind("a.toml:1:8: ", 0), 0u);
  EXPECT_EQ(error("kind = \"cloth\"\npoints = [2, 2, 2]\n"), "a.toml:1:8: kind: expected \"levelset\"");
  EXPECT_EQ(error(sphere), "a.toml:1:1: kind is missing");
  EXPECT_EQ(error("kind = \"levelset\"\n" + sphere), "a.toml:1:1: points is missing");
  EXPECT_EQ(error(head), "a.toml:1:1: sphere, box, torus or mesh is missing");
  EXPECT_EQ(error(head + sphere + mesh), "a.toml:6:1: mesh: expected either shapes or [mesh]");
  EXPECT_EQ(
      error(head + "bandwidth = 3\n" + sphere),
      "a.toml:3:1: unknown key bandwidth, expected one of: kind, points, spacing, origin, band, rounds, distort, sphere, box, torus, mesh");
}

TEST_F(LevelsetSceneTest, RefusesWrongGrids) {
  const auto with = [&](const std::string& points) { return error("kind = \"levelset\"\npoints = " + points + '\n' + sphere); };
  const std::string expected = "points: expected three whole numbers [x, y, z] from 2 to 2147483647";
  for (const char* points : {"64", "[64, 64]", "[2, 2, 2, 2]", "\"64\"", "[]"})
    EXPECT_EQ(with(points), "a.toml:2:10: " + expected) << points;
  for (const char* n : {"1", "0", "-3", "2.0", "nan", "2147483648", "\"2\""})
    EXPECT_EQ(with("[2, " + std::string(n) + ", 2]"), "a.toml:2:14: " + expected);

  const auto line = [&](const std::string& line) { return error(head + line + '\n' + sphere); };
  for (const char* value : {"0", "-0.1", "nan", "inf", "1e-7", "1e7", "\"1\"", "true"})
    EXPECT_EQ(line("spacing = " + std::string(value)), "a.toml:3:11: spacing: expected a number from 1e-6 to 1e6, in m");
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
    EXPECT_EQ(with("rounds = " + std::string(value)), "a.toml:3:10: rounds: expected a whole number from 1 to 2147483647");
  for (const char* value : {"-0.1", "0.91", "nan", "inf", "\"0\""})
    EXPECT_EQ(with("distort = " + std::string(value)), "a.toml:3:11: distort: expected a number from 0 to 0.9");
}

TEST_F(LevelsetSceneTest, RefusesWrongShapes) {
  EXPECT_EQ(error(head + "[sphere]\ncentre = [0, 0, 0]\nradius = 1\n"), "a.toml:3:1: sphere: expected one or more tables [[sphere]]");
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
  EXPECT_EQ(error(head + "[[torus]]\ncentre = [0, 0, 0]\nring = 1\ntube = 1\n"), "a.toml:6:8: tube: expected less than the ring's radius");
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
      "kind = \"levelset\"\npoints = [3, 3, 3]\nspacing = 1\norigin = [-0.5, -0.5, -0.5]\n[[sphere]]\ncentre = [1.5, 1, 1]\nradius = "
      "0.5\n");
  EXPECT_EQ(scene.phi(1, 1, 1), 0);
  EXPECT_EQ(scene.phi(2, 1, 1), 0);
  EXPECT_EQ(std::ranges::count_if(scene.phi.value, [](float phi) { return phi < 0; }), 0);
}

TEST_F(LevelsetSceneTest, RefusesWhatIsTooBig) {
  const auto of = [&](const std::string& points) { return error("kind = \"levelset\"\npoints = " + points + '\n' + sphere); };
  EXPECT_EQ(of("[2147483647, 2147483647, 2147483647]"), "a.toml:2:10: points: expected at most 2147483647 with padding, not 9.9035206e+27");
  EXPECT_EQ(of("[2, 65536, 65536]"), "a.toml:2:10: points: expected at most 2147483647 with padding, not 3.435973837e+11");
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
  EXPECT_EQ(of(corners + "f 1 3 2\nf 1 2 4\nf 1 4 3\n"), "a.obj: the edge of points 2 and 3 is in 1 triangle, expected two: a closed mesh");
  EXPECT_EQ(of(corners + "v 1 1 1\n" + faces + "f 1 2 5\n"),
            "a.obj: the edge of points 1 and 2 is in 3 triangles, expected two: a closed mesh");
  write_bytes(path("a.obj"), corners + faces);
  EXPECT_EQ(error(head + mesh + "scale = 100\n"), "a.toml:1:1: no interface: all points are outside") << "all before its first corner";
}

// --- Shapes

TEST(Shapes, HaveTheDistancesOfClosedForms) {
  const Shape sphere = Sphere{{1, 2, 3}, 2};
  EXPECT_EQ(signed_distance(sphere, {1, 2, 3}), -2);
  EXPECT_EQ(signed_distance(sphere, {1, 6, 6}), 3);
  EXPECT_EQ(signed_distance(sphere, {3, 2, 3}), 0);

  const Shape box = Box{{1, 2, 3}, {1, 2, 3}};
  EXPECT_EQ(signed_distance(box, {1, 2, 3}), -1) << "the nearest side";
  EXPECT_EQ(signed_distance(box, {1, 3.75, 3}), -.25);
  EXPECT_EQ(signed_distance(box, {2, 2, 3}), 0);
  EXPECT_EQ(signed_distance(box, {5, 2, 3}), 3) << "from a side";
  EXPECT_EQ(signed_distance(box, {5, 8, 3}), 5) << "from an edge";
  EXPECT_EQ(signed_distance(box, {-1, -2, -2}), 3) << "from a corner";

  const Shape torus = Torus{{1, 2, 3}, 5, 2};
  EXPECT_EQ(signed_distance(torus, {1, 2, 3}), 3) << "in the hole";
  EXPECT_EQ(signed_distance(torus, {4, 6, 3}), -2) << "on the ring";
  EXPECT_EQ(signed_distance(torus, {4, 6, 6}), 1);
  EXPECT_EQ(signed_distance(torus, {1, -5, 3}), 0);
  EXPECT_EQ(signed_distance(torus, {13, 2, 7}), std::sqrt(65.) - 2);

  EXPECT_EQ(signed_distance({sphere, Sphere{{9, 2, 3}, 1}}, {7, 2, 3}), 1);
  EXPECT_EQ(signed_distance({sphere, Sphere{{9, 2, 3}, 1}}, {9, 2, 3.5}), -.5);
  EXPECT_EQ(signed_distance(std::vector<Shape>(), {0, 0, 0}), infinity);
}

// A distance falls no faster than one goes, and as fast somewhere: its slope is 1.
TEST(Shapes, HaveSlopeOne) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> anywhere(-4, 4);
  for (const Shape& shape : {Shape(Sphere{{0, 0, 0}, 2}), Shape(Box{{0, 0, 0}, {2, 1, 1.5}}), Shape(Torus{{0, 0, 0}, 2, .5})})
    for (int n = 0; n < 1000; ++n) {
      const Vector3<double> p{anywhere(random), anywhere(random), anywhere(random)};
      constexpr double step = 1e-6;
      const auto slope = [&](double x, double y, double z) {
        return (signed_distance(shape, {p.x + step * x, p.y + step * y, p.z + step * z}) -
                signed_distance(shape, {p.x - step * x, p.y - step * y, p.z - step * z})) /
               (2 * step);
      };
      EXPECT_NEAR(std::hypot(slope(1, 0, 0), slope(0, 1, 0), slope(0, 0, 1)), 1, 1e-4);
    }
}

// --- Meshes

Mesh box_mesh(const Vector3<double>& low, const Vector3<double>& high) {
  Mesh mesh;
  for (const double z : {low.z, high.z})
    for (const double y : {low.y, high.y})
      for (const double x : {low.x, high.x}) mesh.points.push_back({x, y, z});
  for (const auto& [a, b, c, d] : {std::array{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}})
    mesh.triangles.push_back({a, b, c}), mesh.triangles.push_back({a, c, d});
  return mesh;
}

// A sphere of radius 1 about the origin in `rings` rings of twice as many points, between two poles.
Mesh sphere_mesh(int rings) {
  Mesh mesh;
  const int around = 2 * rings;
  const auto point = [&](int ring, int k) { return ring * around + k % around; };
  for (int ring = 0; ring < rings; ++ring)
    for (int k = 0; k < around; ++k) {
      const double down = M_PI * (ring + 1) / (rings + 1), along = 2 * M_PI * k / around;
      mesh.points.push_back({std::sin(down) * std::cos(along), std::sin(down) * std::sin(along), std::cos(down)});
    }
  const int north = rings * around, south = north + 1;
  mesh.points.push_back({0, 0, 1}), mesh.points.push_back({0, 0, -1});
  for (int k = 0; k < around; ++k) {
    mesh.triangles.push_back({north, point(0, k), point(0, k + 1)});
    mesh.triangles.push_back({south, point(rings - 1, k + 1), point(rings - 1, k)});
    for (int ring = 0; ring + 1 < rings; ++ring) {
      mesh.triangles.push_back({point(ring, k), point(ring + 1, k), point(ring + 1, k + 1)});
      mesh.triangles.push_back({point(ring, k), point(ring + 1, k + 1), point(ring, k + 1)});
    }
  }
  return mesh;
}

// What the distance of a mesh must be where it is `exact`: that near the mesh, its sign and at least exact_spacings elsewhere.
void expect_distance(double found, double exact, double spacing, double tolerance) {
  const double limit = exact_spacings * spacing;
  EXPECT_NEAR(found, std::clamp(exact, -limit, limit), tolerance);
}

TEST(LevelsetMesh, IsABoxWhoseSidesArePoints) {
  // Lines of points lie in sides, along edges, through corners, and along diagonals that cut the sides into triangles.
  const Grid grid{.nx = 21, .ny = 17, .nz = 19, .spacing = .125, .origin = {-.0625, -.0625, -.0625}};
  const Mesh mesh = box_mesh({.5, .5, .5}, {2, 1.5, 1.5});
  require_closed(mesh, "box");
  const Shape box = Box{{1.25, 1, 1}, {.75, .5, .5}};
  const Field<double> distance = signed_distance(mesh, grid);
  for_each_point(grid, [&](int x, int y, int z) {
    expect_distance(distance(x, y, z), signed_distance(box, grid.position(x, y, z)), grid.spacing, 1e-15);
  });
}

TEST(LevelsetMesh, MayReachOutOfTheGrid) {
  const Grid grid{.nx = 7, .ny = 8, .nz = 9, .spacing = .1, .origin = {0, 0, 0}};
  for (const double left : {-10., .33, 10.}) {
    const Shape box = Box{{left + 5, 0, 0}, {5, 10, 10}};
    const Field<double> distance = signed_distance(box_mesh({left, -10, -10}, {left + 10, 10, 10}), grid);
    for_each_point(grid, [&](int x, int y, int z) {
      expect_distance(distance(x, y, z), signed_distance(box, grid.position(x, y, z)), grid.spacing, 1e-13);
    });
  }
}

TEST(LevelsetMesh, IsASphereUpToItsFaces) {
  std::mt19937 random(1);
  for (const int rings : {5, 20, 60}) {
    Mesh mesh = sphere_mesh(rings);
    require_closed(mesh, "sphere");
    // Which way round triangles are does not matter.
    for (Triangle& t : mesh.triangles)
      if (random() % 2) std::swap(t.a, t.b);
    // Corners are on the sphere, and no edge is longer than the diagonal of a square of side pi / (rings + 1).
    const double radius = M_PI / (rings + 1) * std::sqrt(2.) / std::sqrt(3.), depth = 1 - std::sqrt(1 - std::min(radius * radius, 1.));
    // Points stand on the poles' line, and off it.
    for (const double shift : {0., .0123}) {
      const Grid grid{.nx = 41, .ny = 41, .nz = 41, .spacing = .0625, .origin = {-1.28125 + shift, -1.28125 + shift, -1.28125}};
      const Field<double> distance = signed_distance(mesh, grid);
      for_each_point(grid, [&](int i, int j, int k) {
        const auto [x, y, z] = grid.position(i, j, k);
        expect_distance(distance(i, j, k), std::hypot(x, y, z) - 1, grid.spacing, depth);
      });
    }
  }
}

TEST(LevelsetMesh, TakesTrianglesTooThinToHaveANormal) {
  // A side of the box is cut along a line that is no longer one: its point in the middle belongs to a triangle without an area.
  Mesh mesh = box_mesh({.5, .5, .5}, {2, 1.5, 1.5});
  mesh.points.push_back({1.25, .5, .5});
  for (Triangle& t : mesh.triangles)
    if (t.a == 0 && t.b == 1 && t.c == 5) t = {8, 1, 5};
  mesh.triangles.push_back({0, 8, 5});
  mesh.triangles.push_back({0, 1, 8});
  require_closed(mesh, "box");
  const Grid grid{.nx = 21, .ny = 17, .nz = 19, .spacing = .125, .origin = {-.05, -.0625, -.0625}};
  const Shape box = Box{{1.25, 1, 1}, {.75, .5, .5}};
  const Field<double> distance = signed_distance(mesh, grid);
  for_each_point(grid, [&](int x, int y, int z) {
    expect_distance(distance(x, y, z), signed_distance(box, grid.position(x, y, z)), grid.spacing, 1e-14);
  });
}

// Sides almost along the lines of points, of boxes and of plates of next to no thickness: where a line meets them is hard to say.
TEST(LevelsetMesh, MayBeTurnedByNextToNothing) {
  const Grid grid{.nx = 17, .ny = 17, .nz = 17, .spacing = .125, .origin = {-1.0625, -1.0625, -1.0625}};
  for (const double thickness : {.5, 1e-13})
    for (const double a : {.777546, -.3, 1e-7, 1e-16})
      for (const double b : {-8.34416e-11, -1.5849e-9, 1e-16}) {
        // Turned by a about y, then by b about z.
        const auto turn = [&](const Vector3<double>& p) -> Vector3<double> {
          const double x = std::cos(a) * p.x + std::sin(a) * p.z, z = std::cos(a) * p.z - std::sin(a) * p.x;
          return {std::cos(b) * x - std::sin(b) * p.y, std::sin(b) * x + std::cos(b) * p.y, z};
        };
        const auto turn_back = [&](const Vector3<double>& p) -> Vector3<double> {
          const double x = std::cos(b) * p.x + std::sin(b) * p.y, y = std::cos(b) * p.y - std::sin(b) * p.x;
          return {std::cos(a) * x - std::sin(a) * p.z, y, std::sin(a) * x + std::cos(a) * p.z};
        };
        const Vector3<double> half{thickness, .25, .375};
        Mesh mesh = box_mesh({-half.x, -half.y, -half.z}, half);
        for (Vector3<double>& p : mesh.points) p = turn(p);
        const Shape box = Box{{0, 0, 0}, half};
        const Field<double> distance = signed_distance(mesh, grid);
        for_each_point(grid, [&](int x, int y, int z) {
          expect_distance(distance(x, y, z), signed_distance(box, turn_back(grid.position(x, y, z))), grid.spacing, 1e-12);
        });
      }
}

// The knot has no closed form. But whatever it is, its distance differs between neighbours by no more than they are apart.
TEST(LevelsetMesh, HasNoPhantomInterface) {
  const Mesh mesh = read_obj("scenes/levelset/knot.obj");
  const Grid grid{.nx = 60, .ny = 61, .nz = 62, .spacing = 1. / 60, .origin = {0, 0, 0}};
  const Field<double> distance = signed_distance(mesh, grid);
  for_each_point(grid, [&](int x, int y, int z) {
    const double d = distance(x, y, z), most = grid.spacing * (1 + 1e-9);
    if (x > 0) {
      EXPECT_LE(std::abs(d - distance(x - 1, y, z)), most);
    }
    if (y > 0) {
      EXPECT_LE(std::abs(d - distance(x, y - 1, z)), most);
    }
    if (z > 0) {
      EXPECT_LE(std::abs(d - distance(x, y, z - 1)), most);
    }
  });
}

// --- Where distances begin

template <class Real>
Field<Real> field_of(int nx, int ny, int nz, Real spacing, auto phi) {
  // What padding holds must not matter.
  Field<Real> field = make_field<Real>(nx, ny, nz, spacing, std::numeric_limits<Real>::quiet_NaN());
  for_each_point(field, [&](int x, int y, int z) { field(x, y, z) = static_cast<Real>(phi(x, y, z)); });
  return field;
}

// What is in the way of an answer.
template <class Real>
Distances<Real> litter() {
  return {.distance = make_field<Real>(3, 4, 5, 7, -1), .interface = {{1, 2, 3}}};
}

template <class Real>
Distances<Real> serial_of(const Field<Real>& phi) {
  Distances<Real> distances = litter<Real>();
  serial::initialize(phi, distances);
  return distances;
}

Distances<float> openmp_of(const Field<float>& phi, int threads) {
  Distances<float> distances = litter<float>();
  const int before = omp_get_max_threads();
  omp_set_num_threads(threads);
  openmp::initialize(phi, distances);
  omp_set_num_threads(before);
  return distances;
}

template <class Real>
std::vector<std::array<int, 3>> interface_of(const Distances<Real>& distances) {
  std::vector<std::array<int, 3>> points;
  for (const auto& [x, y, z] : distances.interface) points.push_back({x, y, z});
  return points;
}

void expect_same(const Distances<float>& a, const Distances<float>& b) {
  EXPECT_EQ(interface_of(a), interface_of(b));
  const Field<float>&d = a.distance, &e = b.distance;
  ASSERT_EQ((std::array{d.nx, d.ny, d.nz, d.pitch}), (std::array{e.nx, e.ny, e.nz, e.pitch}));
  EXPECT_EQ(d.spacing, e.spacing);
  ASSERT_EQ(d.value.size(), e.value.size());
  EXPECT_EQ(std::memcmp(d.value.data(), e.value.data(), d.value.size() * sizeof(float)), 0) << "padding as well";
}

TEST(Initialize, HasTheSameBitsAtEveryThreadCount) {
  std::mt19937 random(1);
  std::normal_distribution<float> normal;
  for (const auto& [nx, ny, nz] : {std::array{2, 2, 2}, {3, 1, 2}, {15, 4, 3}, {16, 5, 7}, {17, 9, 2}, {33, 47, 29}, {64, 3, 2}}) {
    // Noise, so that most points are beside the interface; some zeros, of both signs; and one shape, so that few are.
    const Field<float> noise = field_of<float>(nx, ny, nz, .1f, [&](int, int, int) {
      const float phi = normal(random);
      return std::abs(phi) < .1f ? std::copysign(0.f, phi) : phi;
    });
    const Field<float> ball = field_of<float>(nx, ny, nz, .1f, [&](int x, int y, int z) { return std::hypot(x - 9, y - 5, z - 6) - 3.3; });
    for (const Field<float>* phi : {&noise, &ball})
      for (const int threads : {1, 2, 3, 5}) expect_same(serial_of(*phi), openmp_of(*phi, threads));
  }
}

TEST(Initialize, ListsWhatIsBesideTheInterfaceInOrder) {
  std::mt19937 random(1);
  const Field<float> phi = field_of<float>(18, 7, 6, 1, [&](int, int, int) {
    return random() % 10 == 0 ? -1 : random() % 20 == 0 ? 0 : 2;
  });
  std::vector<std::array<int, 3>> expected;
  const auto sign = [&](int x, int y, int z) { return phi(x, y, z) < 0 ? -1 : phi(x, y, z) > 0 ? 1 : 0; };
  for_each_point(phi, [&](int x, int y, int z) {
    const int s = sign(x, y, z);
    if (s == 0 || (x > 0 && sign(x - 1, y, z) != s) || (x < 17 && sign(x + 1, y, z) != s) || (y > 0 && sign(x, y - 1, z) != s) ||
        (y < 6 && sign(x, y + 1, z) != s) || (z > 0 && sign(x, y, z - 1) != s) || (z < 5 && sign(x, y, z + 1) != s))
      expected.push_back({x, y, z});
  });
  const Distances<float> distances = serial_of(phi);
  EXPECT_EQ(interface_of(distances), expected);
  std::size_t known = 0;
  for (const float d : distances.distance.value) known += d != far<float>;
  EXPECT_EQ(known, expected.size());
  for (const auto& [x, y, z] : distances.interface) {
    EXPECT_LE(distances.distance(x, y, z), 1);
    EXPECT_EQ(distances.distance(x, y, z) == 0, phi(x, y, z) == 0);
  }
}

// Along an axis that a plane comes near it crosses at exact places; so where it crosses all axes that it is not along, it is where it is.
template <class Real>
void expect_planes_exact(Real tolerance) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> anywhere(-1, 1);
  constexpr double spacing = .25;
  int exact_points = 0;
  for (int n = 0; n < 60; ++n) {
    // At first planes along two axes, along one, and ones that cut all alike.
    std::array<double, 3> normal{};
    for (int axis = 0; axis < 3; ++axis) normal[axis] = n >= 14 ? anywhere(random) : (n / 2 + 1) >> axis & 1;
    if (n < 14 && n % 2) normal[0] = -normal[0], normal[2] = -normal[2];
    const double length = std::hypot(normal[0], normal[1], normal[2]), offset = anywhere(random);
    for (double& x : normal) x /= length;
    const auto from_plane = [&](int x, int y, int z) {
      return spacing * (normal[0] * (x - 8) + normal[1] * (y - 6) + normal[2] * (z - 7)) - offset;
    };
    for (const double slope : {1., -1., 1e-12, 3e9}) {
      const Distances<Real> distances =
          serial_of(field_of<Real>(17, 13, 15, spacing, [&](int x, int y, int z) { return slope * from_plane(x, y, z); }));
      EXPECT_FALSE(distances.interface.empty());
      for (const auto& [x, y, z] : distances.interface) {
        const double exact = std::abs(from_plane(x, y, z));
        const Real found = distances.distance(x, y, z);
        EXPECT_GE(found, exact - tolerance) << "too near";
        EXPECT_LE(found, spacing * (1 + tolerance)) << "too far";
        const int place[] = {x, y, z}, size[] = {17, 13, 15};
        bool all_axes = true;
        for (int axis = 0; axis < 3; ++axis) {
          const int towards = from_plane(x, y, z) * normal[axis] > 0 ? -1 : 1;
          const bool there = place[axis] + towards >= 0 && place[axis] + towards < size[axis];
          all_axes &= normal[axis] == 0 || (there && exact <= .999 * spacing * std::abs(normal[axis]));
        }
        if (!all_axes) continue;
        ++exact_points;
        EXPECT_NEAR(found, exact, tolerance);
      }
    }
  }
  EXPECT_GT(exact_points, 10'000);
}

TEST(Initialize, IsExactForPlanes) {
  expect_planes_exact<float>(2e-6f);
  expect_planes_exact<double>(1e-14);
}

// Planes through points: these are at 0, and their neighbours on both sides are as far as they are.
TEST(Initialize, IsExactForPlanesThroughPoints) {
  for (const int sign : {1, -1}) {
    const Distances<float> d = serial_of(field_of<float>(20, 6, 5, .5f, [&](int x, int y, int) { return sign * (x + y - 11); }));
    for_each_point(d.distance, [&](int x, int y, int z) {
      const int steps = std::abs(x + y - 11);
      const bool has_both = x + y < 11 ? y < 5 : y > 0;
      if (steps == 0) {
        EXPECT_EQ(d.distance(x, y, z), 0);
      }
      if (steps == 1 && has_both) {
        EXPECT_FLOAT_EQ(d.distance(x, y, z), .5 / std::sqrt(2.));
      }
      if (steps > 1) {
        EXPECT_EQ(d.distance(x, y, z), far<float>);
      }
    });
  }
}

TEST(Initialize, TakesAnyFinitePhi) {
  for (const float small : {std::numeric_limits<float>::denorm_min(), 1e-38f, 1e-20f, 1.f, 1e38f})
    for (const float large : {1e-30f, 1.f, 1e38f}) {
      const Field<float> phi = field_of<float>(18, 3, 2, .5f, [&](int x, int, int) { return x < 9 ? -small : large; });
      const Distances<float> d = serial_of(phi);
      EXPECT_EQ(d.interface.size(), 2 * 3 * 2u);
      EXPECT_NEAR(d.distance(8, 1, 1), .5 * small / (double(small) + large), 1e-7);
      EXPECT_NEAR(d.distance(9, 1, 1), .5 * large / (double(small) + large), 1e-7);
      expect_same(d, openmp_of(phi, 2));
    }
}

TEST(Initialize, FindsNothingWhereThereIsNone) {
  const Field<float> phi = field_of<float>(18, 3, 2, .5f, [](int, int, int) { return 1; });
  for (const Distances<float>& d : {serial_of(phi), openmp_of(phi, 2)}) {
    EXPECT_TRUE(d.interface.empty());
    EXPECT_TRUE(std::ranges::all_of(d.distance.value, [](float x) { return x == far<float>; }));
  }
}

// --- Images

struct LevelsetImageTest : LevelsetSceneTest {
  const Grid grid{.nx = 3, .ny = 2, .nz = 2, .spacing = .25, .origin = {1, 2, 3}};
  const Field<float> field = field_of<float>(3, 2, 2, .25f, [](int x, int y, int z) { return (x - 1) * 1.5 + 10 * y - 100 * z; });
  const std::vector<float> clamped{-1.5, 0, 1.5, 2, 2, 2, -2, -2, -2, -2, -2, -2};
};

TEST_F(LevelsetImageTest, WritesXml) {
  write_image(path("a.vti"), field, grid, 2);
  const std::string bytes = read_bytes(path("a.vti")), begin = "<AppendedData encoding=\"raw\">\n_",
                    end = "\n</AppendedData>\n</VTKFile>\n";
  const std::size_t data = bytes.find(begin) + begin.size();
  EXPECT_EQ(bytes.substr(0, data),
            "<?xml version=\"1.0\"?>\n"
            "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
            "<ImageData WholeExtent=\"0 2 0 1 0 1\" Origin=\"1.125 2.125 3.125\" Spacing=\"0.25 0.25 0.25\">\n"
            "<Piece Extent=\"0 2 0 1 0 1\">\n<PointData Scalars=\"phi\">\n"
            "<DataArray type=\"Float32\" Name=\"phi\" format=\"appended\" offset=\"0\"/>\n"
            "</PointData>\n</Piece>\n</ImageData>\n" +
                begin);
  std::uint64_t size;
  std::vector<float> values(12);
  ASSERT_EQ(bytes.size(), data + sizeof size + 48 + end.size());
  std::memcpy(&size, &bytes[data], sizeof size);
  EXPECT_EQ(size, 48u);
  std::memcpy(values.data(), &bytes[data + sizeof size], 48);
  EXPECT_EQ(values, clamped);
  EXPECT_EQ(bytes.substr(data + sizeof size + 48), end);
}

TEST_F(LevelsetImageTest, WritesLegacy) {
  write_image(path("a.vtk"), field, grid, 2);
  const std::string bytes = read_bytes(path("a.vtk")), begin = "LOOKUP_TABLE default\n";
  const std::size_t data = bytes.find(begin) + begin.size();
  EXPECT_EQ(bytes.substr(0, data),
            "# vtk DataFile Version 3.0\nLockstep level set\nBINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS 3 2 2\n"
            "ORIGIN 1.125 2.125 3.125\nSPACING 0.25 0.25 0.25\nPOINT_DATA 12\nSCALARS phi float 1\n" +
                begin);
  ASSERT_EQ(bytes.size(), data + 48 + 1);
  std::vector<float> values;
  for (std::size_t i = data; i < data + 48; i += 4) {
    std::uint32_t word = 0;
    for (int k = 0; k < 4; ++k) word = word << 8 | static_cast<unsigned char>(bytes[i + k]);
    values.push_back(std::bit_cast<float>(word));
  }
  EXPECT_EQ(values, clamped);
  EXPECT_EQ(bytes.back(), '\n');
}

TEST_F(LevelsetImageTest, ClampsNothingWithoutABand) {
  write_image(path("a.vti"), field, grid, std::numeric_limits<float>::infinity());
  const std::string bytes = read_bytes(path("a.vti"));
  float last;
  std::memcpy(&last, &bytes[bytes.find("\n</AppendedData>") - sizeof last], sizeof last);
  EXPECT_EQ(last, 1.5f + 10 - 100);
}

TEST_F(LevelsetImageTest, WritesTheWholeFileOrNothing) {
  for (const std::string name : {"a.raw", "a", "a.vti.gz"})
    EXPECT_EQ(error_of([&] { write_image(path(name), field, grid, 2); }), path(name) + ": expected a name that ends in .vti or .vtk");
  EXPECT_EQ(error_of([&] { write_image(path("none/a.vti"), field, grid, 2); }),
            path("none/a.vti") + ": cannot be written: No such file or directory");
  EXPECT_EQ(files(), 0);
}

}  // namespace
}  // namespace lockstep::levelset
