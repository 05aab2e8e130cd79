// Hulls are convex and closed, coplanar triangles are one face, and points without a hull are refused.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <vector>

#include "tests/rigid_worlds.h"

namespace lockstep::rigid::worlds {
namespace {

double extent_of(const std::vector<Vector>& points) {
  double extent = 0;
  for (const Vector& p : points)
    for (const Vector& q : points) extent = std::max({extent, p.x - q.x, p.y - q.y, p.z - q.z});
  return extent;
}

double size_of(const std::vector<Vector>& points) {
  double size = 0;
  for (const Vector& p : points) size = std::max({size, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  return size;
}

// The hull is closed, of one piece without holes, convex, around all points, and in the order of the contract.
void expect_hull(const std::vector<Vector>& points) {
  World<double> world = make_world();
  const Hulls<double>& hulls = world.hulls;
  const int h = make_hull(world.hulls, points);
  ASSERT_EQ(h, 3);
  ASSERT_EQ(hulls.count, 4);
  const int vertices = hulls.vertices(h), faces = hulls.faces(h);
  const std::vector<std::vector<int>> corners = faces_of(hulls, h);
  EXPECT_LE(vertices, most_hull_vertices);
  EXPECT_GE(hulls.most_vertices, vertices);

  // Each edge occurs once in each direction. V - E + F = 2 then says that the surface has one piece and no holes.
  std::set<std::pair<int, int>> edges;
  for (const auto& face : corners) {
    EXPECT_GE(face.size(), 3u);
    EXPECT_EQ(face[0], *std::ranges::min_element(face));
    for (std::size_t k = 0; k < face.size(); ++k)
      EXPECT_TRUE(edges.insert({face[k], face[(k + 1) % face.size()]}).second);
  }
  for (const auto& [a, b] : edges) EXPECT_TRUE(edges.contains({b, a}));
  EXPECT_EQ(vertices - static_cast<int>(edges.size()) / 2 + faces, 2);
  EXPECT_TRUE(std::ranges::is_sorted(corners));

  // Vertices are points, in their order.
  std::size_t next = 0;
  for (int i = 0; i < vertices; ++i) {
    const Vector v = vertex_of(hulls, h, i);
    while (next < points.size() && !(points[next].x == v.x && points[next].y == v.y && points[next].z == v.z)) ++next;
    EXPECT_LT(next++, points.size()) << "vertex " << i << " is no point, or not in their order";
  }

  // A product of a unit vector and a vertex rounds three products and two sums, of at most 3 size. The plane's distance
  // is one of these products. The length of its normal is 1 to within about 4 u.
  const double rounding = 40 * u * size_of(points), error = hull_error * extent_of(points);
  for (int f = 0; f < faces; ++f) {
    const auto [x, y, z, distance] = hulls.plane[hulls.first_face[h] + f];
    EXPECT_NEAR(x * x + y * y + z * z, 1, 8 * u);
    const auto outside = [&, &x = x, &y = y, &z = z, &d = distance](const Vector& p) {
      return x * p.x + y * p.y + z * p.z - d;
    };
    for (int i = 0; i < vertices; ++i) EXPECT_LE(outside(vertex_of(hulls, h, i)), rounding);
    for (const Vector& p : points) EXPECT_LE(outside(p), error + rounding);
    // The plane goes through the farthest vertex, at most hull_error beyond the mean of the corners. A corner is at
    // most as far below the mean.
    for (const int corner : corners[f]) EXPECT_GE(outside(vertex_of(hulls, h, corner)), -2 * error - rounding);
  }
  for (int i = 0; i < vertices; ++i) {
    const Vector v = vertex_of(hulls, h, i);
    const Quad<double>&c = hulls.centre[h], &half = hulls.half[h];
    EXPECT_LE(std::abs(v.x - c.x), half.x + rounding);
    EXPECT_LE(std::abs(v.y - c.y), half.y + rounding);
    EXPECT_LE(std::abs(v.z - c.z), half.z + rounding);
  }
}

TEST(RigidHulls, AreConvexAndClosed) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> within(-1, 1);
  for (int n = 0; n < 400; ++n) {
    const int count = 6 + static_cast<int>(random() % 55);
    const double noise = std::pow(10, -9 + 5 * std::abs(within(random)));
    std::vector<Vector> ellipsoid, grid, shell;
    for (int i = 0; i < count; ++i) {
      const Vector p{within(random), within(random), within(random)}, d = 1 / length(p) * p;
      ellipsoid.push_back({.75 * d.x + 3, .5 * d.y, .45 * d.z});
      const auto near_whole = [&] { return static_cast<double>(random() % 4) + noise * within(random); };
      grid.push_back({near_whole(), near_whole(), near_whole()});
      shell.push_back(i % 2 ? Vector{p.x, noise * p.y, p.z}
                            : Vector{.5 * p.x, -noise * (p.x * p.x + p.z * p.z) - .1, .5 * p.z});
    }
    for (int i = 0; i < 8; ++i) grid.push_back({3. * (i % 2), 3. * (i / 2 % 2), 3. * (i / 4)});  // never flat
    expect_hull(ellipsoid);
    expect_hull(grid);
    expect_hull(shell);
    if (HasFailure()) FAIL() << "in round " << n;
  }
}

TEST(RigidHulls, MergeWhatIsCoplanar) {
  for (const double turn : {0., .3}) {
    for (const Vector& far : {Vector{0, 0, 0}, {1000, -2000, .3}}) {
      std::vector<Vector> grid;  // the corners, and points on edges, in faces and inside
      for (int i = 0; i < 125; ++i) {
        const double x = i % 5 - 2., y = i / 5 % 5 - 2., z = i / 25 - 2.;
        grid.push_back(far +
                       Vector{std::cos(turn) * x - std::sin(turn) * y, std::sin(turn) * x + std::cos(turn) * y, z});
      }
      expect_hull(grid);
      World<double> world = make_world();
      const int cube = make_hull(world.hulls, grid);
      EXPECT_EQ(world.hulls.vertices(cube), 8);
      EXPECT_EQ(faces_of(world.hulls, cube).size(), 6u);
      for (const auto& face : faces_of(world.hulls, cube)) EXPECT_EQ(face.size(), 4u);
    }
  }
  std::vector<Vector> cylinder;  // written with six digits
  for (int i = 0; i < 20; ++i)
    for (const double y : {-1., 1.})
      cylinder.push_back(
          {std::round(1e6 * std::cos(M_PI * i / 10)) / 1e6, y, std::round(1e6 * std::sin(M_PI * i / 10)) / 1e6});
  expect_hull(cylinder);
  World<double> world = make_world();
  EXPECT_EQ(world.hulls.faces(make_hull(world.hulls, cylinder)), 22);
}

TEST(RigidHulls, RefuseWhatHasNone) {
  World<double> world = make_world();
  const auto of = [&](const std::vector<Vector>& points) { return invalid([&] { make_hull(world.hulls, points); }); };
  EXPECT_EQ(of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}), "3 points, a hull has at least 4");
  EXPECT_EQ(of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, NAN}}), "a point is not finite");
  EXPECT_EQ(of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, INFINITY}}), "a point is not finite");
  EXPECT_EQ(of({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}}), "the points are flat");
  EXPECT_EQ(of({{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {3, 3, 3}}), "the points are flat");
  EXPECT_EQ(of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}), "the points are flat");
  EXPECT_EQ(of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {.3, .3, .9e-6}}), "the points are flat");
  EXPECT_EQ(of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {.3, .3, 1e-5}}), "no error");
  std::vector<Vector> sphere;
  for (int i = 0; i < 65; ++i) {
    const double y = (i - 32) / 33., r = std::sqrt(1 - y * y);
    sphere.push_back({r * std::cos(2.4 * i), y, r * std::sin(2.4 * i)});
  }
  EXPECT_EQ(of(sphere), "a hull of 65 vertices, at most 64");
  EXPECT_EQ(world.hulls.count, 4) << "the one without an error";
}

TEST(RigidHulls, AllWorldsHaveThree) {
  const World<double> world = make_world();
  EXPECT_EQ(world.hulls.count, 3);
  EXPECT_EQ(world.hulls.vertices(point_hull), 1);
  EXPECT_EQ(world.hulls.vertices(segment_hull), 2);
  EXPECT_EQ(world.hulls.faces(segment_hull), 0);
  EXPECT_EQ(world.hulls.vertices(cube_hull), 8);
  EXPECT_EQ(world.hulls.faces(cube_hull), 6);
  std::vector<Vector> corners;
  for (int i = 0; i < 8; ++i) corners.push_back(vertex_of(world.hulls, cube_hull, i));
  World<double> other = make_world();
  const int cube = make_hull(other.hulls, corners);
  std::set<std::vector<int>> expected, found;
  for (const auto& face : faces_of(other.hulls, cube)) expected.insert(face);
  for (const auto& face : faces_of(world.hulls, cube_hull)) found.insert(face);
  EXPECT_EQ(found, expected);
  for (int f = 0; f < 6; ++f) {
    const auto [x, y, z, distance] = world.hulls.plane[world.hulls.first_face[cube_hull] + f];
    EXPECT_EQ(distance, 1);
    EXPECT_EQ((f % 2 ? 1 : -1), f / 2 == 0 ? x : f / 2 == 1 ? y : z);
  }
}

TEST(RigidHulls, OfATriangleHasTwoSides) {
  World<double> world = make_world();
  begin_body(world, {{1, 2, 3}, no_rotation, 0});
  add_mesh(world, {{{0, 0, 0}, {0, 0, 4}, {2, 0, 0}}, {{0, 1, 2}}});
  finish_body(world, immovable);
  ASSERT_EQ(world.hulls.count, 4);
  EXPECT_EQ(faces_of(world.hulls, 3), (std::vector<std::vector<int>>{{0, 1, 2}, {0, 2, 1}}));
  EXPECT_EQ(world.hulls.plane[world.hulls.first_face[3]].y, 1);
  EXPECT_EQ(world.hulls.plane[world.hulls.first_face[3] + 1].y, -1);
  expect_near(world.colliders.local[0].position, {1, 0, 2}, 0);
  expect_near(vertex_of(world.hulls, 3, 2), {1, 0, -2}, 0);
  const auto of = [&](const Vector& third) {
    return invalid([&] { add_mesh(world, {{{0, 0, 0}, {0, 0, 4}, third}, {{0, 1, 2}}}); });
  };
  EXPECT_EQ(of({0, 0, 2}), "triangle 1 is thinner than a plane needs");
  EXPECT_EQ(of({1e-7, 0, 2}), "triangle 1 is thinner than a plane needs");
  // Beside its first or second corner: around the triangle's middle, the two would be one point.
  EXPECT_EQ(of({1e-30, 0, 0}), "triangle 1 is thinner than a plane needs");
  EXPECT_EQ(of({1e-30, 0, 4}), "triangle 1 is thinner than a plane needs");
  EXPECT_EQ(of({1e-5, 0, 0}), "no error");
}

}  // namespace
}  // namespace lockstep::rigid::worlds
