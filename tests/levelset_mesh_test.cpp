// Shapes and meshes of the level set: their distances are those of closed forms.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "common/levelset/mesh.h"
#include "common/levelset/scene.h"
#include "common/levelset/shapes.h"
#include "common/mesh_file.h"
#include "tests/levelset_fields.h"

namespace lockstep::levelset {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

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
  for (const Shape& shape :
       {Shape(Sphere{{0, 0, 0}, 2}), Shape(Box{{0, 0, 0}, {2, 1, 1.5}}), Shape(Torus{{0, 0, 0}, 2, .5})})
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
  for (const auto& [a, b, c, d] :
       {std::array{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}})
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

// What the distance of a mesh must be where it is `exact`: that near the mesh, its sign and at least exact_spacings
// elsewhere.
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
    const double radius = M_PI / (rings + 1) * std::sqrt(2.) / std::sqrt(3.),
                 depth = 1 - std::sqrt(1 - std::min(radius * radius, 1.));
    // Points stand on the poles' line, and off it.
    for (const double shift : {0., .0123}) {
      const Grid grid{
          .nx = 41, .ny = 41, .nz = 41, .spacing = .0625, .origin = {-1.28125 + shift, -1.28125 + shift, -1.28125}};
      const Field<double> distance = signed_distance(mesh, grid);
      for_each_point(grid, [&](int i, int j, int k) {
        const auto [x, y, z] = grid.position(i, j, k);
        expect_distance(distance(i, j, k), std::hypot(x, y, z) - 1, grid.spacing, depth);
      });
    }
  }
}

TEST(LevelsetMesh, TakesTrianglesTooThinToHaveANormal) {
  // A side of the box is cut along a line that is no longer one: its point in the middle belongs to a triangle without
  // an area.
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

// Sides almost along the lines of points, of boxes and of plates of next to no thickness: where a line meets them is
// hard to say.
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
          expect_distance(distance(x, y, z), signed_distance(box, turn_back(grid.position(x, y, z))), grid.spacing,
                          1e-12);
        });
      }
}

// The knot has no closed form. But whatever it is, its distance differs between neighbours by no more than they are
// apart.
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

}  // namespace
}  // namespace lockstep::levelset
