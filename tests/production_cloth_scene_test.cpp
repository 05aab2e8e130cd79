// Scenes of the production cloth: topology, sheets and tubes, what is refused; bodies that move, and vertices that they
// push out.
#include "common/production_cloth/scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>
#include <set>

#include "common/convert.h"
#include "common/production_cloth/collide_bodies.h"
#include "common/production_cloth/masses.h"
#include "common/production_cloth/sheets.h"
#include "tests/temporary_folder.h"

namespace lockstep::production_cloth {
namespace {

Mesh small_sheet(int columns, int rows) {
  return make_sheet({.origin = {0, 0, 0}, .across = {1, 0, 0}, .down = {0, 0, 1}, .squares = {columns, rows}});
}

Topology topology_of(const Mesh& mesh) {
  return make_topology(static_cast<int>(mesh.points.size()), mesh.triangles, "mesh");
}

// Euler's formula: a disk has vertices - edges + triangles = 1, a tube 0.
TEST(ProductionClothTopology, CountsEdgesAndHinges) {
  const Topology sheet = topology_of(small_sheet(5, 3));
  EXPECT_EQ(sheet.vertices - int(sheet.edges.size()) + int(sheet.triangles.size()), 1);
  EXPECT_EQ(sheet.hinges.size(), sheet.edges.size() - 2 * (5 + 3));
  const Topology tube = topology_of(make_tube({{0, 0, 0}, {2, 0, 0}, .5, {7, 4}}));
  EXPECT_EQ(tube.vertices - int(tube.edges.size()) + int(tube.triangles.size()), 0);
  EXPECT_EQ(tube.hinges.size(), tube.edges.size() - 2 * 7);
}

// The hinge's first triangle is (0, 2, 3) and its second (1, 3, 2), turned as they stand in the mesh.
TEST(ProductionClothTopology, HingesKeepTheTurnOfTheirTriangles) {
  const Topology t = topology_of(small_sheet(4, 4));
  std::set<std::array<std::int32_t, 3>> turned;
  for (std::size_t k = 0; k < t.triangles.size(); ++k) {
    const auto [a, b, c] = t.corners(k);
    turned.insert({{a, b, c}, {b, c, a}, {c, a, b}});
  }
  for (const auto& [x, y, p, q] : t.hinges) {
    EXPECT_TRUE(turned.contains({x, p, q}));
    EXPECT_TRUE(turned.contains({y, q, p}));
  }
  for (std::size_t k = 0; k < t.triangles.size(); ++k)
    for (int c = 0; c < 3; ++c)
      for (const std::int32_t v : t.edges[t.edges_of[k][c]]) EXPECT_NE(v, t.corners(k)[c]);
}

std::string refusal(int vertices, const std::vector<Triangle>& triangles) {
  return error_of([&] { make_topology(vertices, triangles, "a"); });
}

TEST(ProductionClothTopology, RefusesWhatIsNoManifold) {
  EXPECT_EQ(refusal(3, {{0, 1, 3}}), "a: triangle 1: vertex 4 does not exist, expected 1 to 3");
  EXPECT_EQ(refusal(3, {{0, 1, 1}}), "a: triangle 1 has vertex 2 twice");
  EXPECT_EQ(refusal(5, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}),
            "a: the edge of vertices 1 and 2 is in 3 triangles, expected at most two");
  EXPECT_EQ(refusal(4, {{0, 1, 2}, {0, 1, 3}}),
            "a: triangles 1 and 2 turn opposite ways about the edge of vertices 1 and 2");
  EXPECT_EQ(refusal(4, {{0, 1, 2}}), "a: vertex 4 is in no triangle");
}

TEST(ProductionClothMasses, SumUpToTheCloths) {
  const Mesh mesh = small_sheet(3, 5);
  Vectors<double> rest;
  rest.resize(mesh.points.size());
  for (std::size_t i = 0; i < mesh.points.size(); ++i) store(rest, i, mesh.points[i]);
  const Array<double> mass = lumped_masses(topology_of(mesh), rest, 2);
  double sum = 0;
  for (const double m : mass) sum += m;
  EXPECT_NEAR(sum, 2, 1e-14);  // 2 kg/m^2, one square metre; 48 roundings of parts below 2 u each
}

struct ProductionClothScene : TemporaryFolder {
  std::string error(const std::string& text) const {
    write_bytes(path("a.toml"), "kind = \"production_cloth\"\n" + text);
    return error_of([&] { load_scene(path("a.toml")); });
  }
  const std::string sheet = "[[sheet]]\norigin = [0, 0, 0]\nacross = [1, 0, 0]\ndown = [0, 1, 0]\nsquares = [2, 3]\n";
};

TEST_F(ProductionClothScene, OfTheRepositoryLoad) {
  for (const auto& file : std::filesystem::directory_iterator("scenes/production_cloth")) {
    if (file.path().extension() != ".toml") continue;
    const Scene scene = load_scene(file.path().string());
    EXPECT_GT(scene.topology.hinges.size(), 0u) << scene.name;
  }
}

TEST_F(ProductionClothScene, RefusesBadCloths) {
  const auto says = [&](const std::string& text, const std::string& what) {
    EXPECT_NE(error(text).find(what), std::string::npos) << text << error(text);
  };
  says("", "expected at least one of sheet, tube and mesh");
  says("[[sheet]]\norigin = [0, 0, 0]\nacross = [1, 0, 0]\ndown = [2, 0, 0]\nsquares = [2, 3]\n",
       "another direction than `across`");
  says("[[sheet]]\norigin = [0, 0, 0]\nacross = [1, 0, 0]\ndown = [0, 1, 0]\nsquares = [2, 3.5]\n", "whole numbers");
  says(sheet + "[contact]\nthickness = 0.4\n", "expected longer than the thickness");
  says(sheet + "[[hold]]\nfrom = [5, 5, 5]\nto = [6, 6, 6]\n", "no vertex is in the box");
  says(sheet + "[[sphere]]\ncentre = [0, 0, 0]\nradius = 1\n[[sphere.key]]\ntime = 2\n[[sphere.key]]\ntime = 1\n",
       "a later time");
  says(sheet + "[material]\nstretch = \"rubber\"\n", "one of: springs, stvk, corotated");
  says("[[sheet]]\norigin = [0, 0, 0]\nacross = [1, 0, 0]\ndown = [0, 1, 0]\nsquares = [10000, 10000]\n", "triangles");
  write_bytes(path("a.obj"), "v 0 0 0\nv 1 0 0\nv 0.5 0.00001 0\nf 1 2 3\n");
  says("[[mesh]]\nfile = \"a.obj\"\n", "is degenerate");
}

// --- Bodies

// d(x) of a body that turns and shifts is where the point that ends at x has come from.
TEST(ProductionClothBodies, KnowHowFarTheirPointsHaveMoved) {
  Body body = {.shape = cloth::Capsule<double>{{0, 0, 0}, {0, 1, 0}, .1}, .friction = 0, .path = {}};
  body.path = {.pivot = {.2, .3, .4}, .keys = {{0, {{0, 0, 0}, {0, 0, 0}}}, {1, {{.3, -.5, .7}, {.1, .2, -.3}}}}};
  const MovedBodies<float> moved = move_bodies({body}, .25, .75, 0);
  const Placement before = placement_at(body.path, .25), now = placement_at(body.path, .75);
  const Vector3<double> point = {.1, .9, -.2}, from = placed(body.path, before, point),
                        to = placed(body.path, now, point);
  const Vector3<float> d = displacement_of(moved.capsules[0], convert<float>(to));
  // Of a component three entries, three coordinates and the shift are rounded, three products and three sums: thirteen
  // roundings of numbers below 1.
  constexpr double bound = 13 * 0x1p-24;
  EXPECT_NEAR(d.x, to.x - from.x, bound);
  EXPECT_NEAR(d.y, to.y - from.y, bound);
  EXPECT_NEAR(d.z, to.z - from.z, bound);
}

// Vertices 0, 1, 2, ... over a plane at height 0, of which each second has sunk by .01 and slid by .03.
struct OverPlane {
  int vertices;
  Array<float> inverse_mass;
  Vectors<float> start;
  Motion<float> motion;
  MovedBodies<float> bodies;

  OverPlane(int vertices, double friction, const Vector3<double>& shift) : vertices(vertices) {
    inverse_mass.resize(padded(vertices));
    start.resize(vertices), motion.position.resize(vertices), motion.velocity.resize(vertices);
    for (int i = 0; i < vertices; ++i) {
      inverse_mass[i] = 1;
      store(start, i, {float(i), .01f, 0});
      store(motion.position, i, {float(i), i % 2 ? .02f : -.01f, .03f});
      store(motion.velocity, i, {0, 0, 7});
    }
    const Body plane = {.shape = cloth::Plane<double>{{0, 1, 0}, 0},
                        .friction = friction,
                        .path = {.pivot = {0, 0, 0}, .keys = {{0, {}}, {1, {{0, 0, 0}, shift}}}}};
    bodies = move_bodies({plane}, 0, 1, 0);
  }
  void push(bool is_serial) {
    CollideBodies<float>* const serial_form = serial::collide_bodies;
    CollideBodies<float>* const f = is_serial ? serial_form : openmp::collide_bodies;
    f(bodies, vertices, .1f, inverse_mass, start, motion.position, motion.velocity);
  }
};

TEST(ProductionClothBodies, PushOutWithCoulombsFriction) {
  for (const int vertices : {0, 1, 15, 16, 17, 100})
    for (const bool is_serial : {true, false}) {
      OverPlane over(vertices, .5, {0, 0, 0});
      over.push(is_serial);
      for (int i = 0; i < vertices; ++i) {
        const Vector3<float> p = load(over.motion.position, i), v = load(over.motion.velocity, i);
        if (i % 2) {
          EXPECT_EQ(p.z, .03f);
          EXPECT_EQ(v.z, 7);
          continue;
        }
        EXPECT_EQ(p.y, 0);
        // Friction times the depth is taken back. Eight roundings of numbers up to .03: the slide and its length, the
        // depth, what friction takes, its share, the product, the difference, and .03 itself.
        EXPECT_NEAR(p.z, .03 - .5 * .01, 8 * .03 * 0x1p-24);
        // The time step, its inverse and the product are rounded, and for y the height of .01.
        EXPECT_NEAR(v.z, p.z / .1, 3 * .25 * 0x1p-24);
        EXPECT_NEAR(v.y, -.1, 4 * .1 * 0x1p-24);
      }
    }
}

// A body that moves along its surface takes along what friction holds.
TEST(ProductionClothBodies, CarryWhatStands) {
  OverPlane over(20, 100, {0, 0, .03 + .2});
  over.push(false);
  // The shift, the way relative to the body, and the difference are rounded, all below .25.
  for (int i = 0; i < 20; i += 2) EXPECT_NEAR(load(over.motion.position, i).z, .23, 3 * .25 * 0x1p-24);
}

TEST(ProductionClothBodies, LeaveHeldVerticesAlone) {
  OverPlane over(20, .5, {0, 0, 0});
  over.inverse_mass[4] = 0;
  over.push(false);
  EXPECT_EQ(load(over.motion.position, 4).y, -.01f);
}

}  // namespace
}  // namespace lockstep::production_cloth
