// Scenes of rigid bodies, how their worlds are made, and frames: hulls are convex and closed, masses are those of closed forms, scenes of
// the repository load and are what their names say, a bad one is refused in one line that says where.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <map>
#include <random>
#include <set>
#include <stdexcept>

#include "common/convert.h"
#include "common/obj.h"
#include "common/rigid/generators.h"
#include "common/rigid/make.h"
#include "common/rigid/scene.h"
#include "common/rigid/vtk.h"
#include "verify/domain.h"
#include "tests/exact_convex.h"
#include "tests/temporary_folder.h"

namespace lockstep::rigid {
namespace {

using Vector = Vector3<double>;
constexpr double u = std::numeric_limits<double>::epsilon() / 2;  // a rounding

void expect_near(const Vector& a, const Vector& b, double tolerance) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

std::string invalid(auto action) {
  try {
    action();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "no error";
}

// --- Hulls

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

Vector vertex_of(const Hulls<double>& hulls, int hull, int corner) {
  const Quad<double>& v = hulls.vertex[hulls.first_vertex[hull] + corner];
  return {v.x, v.y, v.z};
}

std::vector<std::vector<int>> faces_of(const Hulls<double>& hulls, int hull) {
  std::vector<std::vector<int>> faces;
  for (int f = hulls.first_face[hull]; f < hulls.first_face[hull + 1]; ++f)
    faces.emplace_back(hulls.corner.begin() + hulls.first_corner[f], hulls.corner.begin() + hulls.first_corner[f + 1]);
  return faces;
}

// Closed, of one piece without holes, convex, around all points, and in the order that the contract says.
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

  // Each edge once in each direction; then V - E + F = 2 says that there is one piece, and no hole through it.
  std::set<std::pair<int, int>> edges;
  for (const auto& face : corners) {
    EXPECT_GE(face.size(), 3u);
    EXPECT_EQ(face[0], *std::ranges::min_element(face));
    for (std::size_t k = 0; k < face.size(); ++k) EXPECT_TRUE(edges.insert({face[k], face[(k + 1) % face.size()]}).second);
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

  // A product of unit vector and vertex has three roundings of products and two of sums, of at most 3 size; the plane's distance is one of
  // these, and its normal is of length 1 to within 4 u or so.
  const double rounding = 40 * u * size_of(points), error = hull_error * extent_of(points);
  for (int f = 0; f < faces; ++f) {
    const auto [x, y, z, distance] = hulls.plane[hulls.first_face[h] + f];
    EXPECT_NEAR(x * x + y * y + z * z, 1, 8 * u);
    const auto outside = [&, &x = x, &y = y, &z = z, &d = distance](const Vector& p) { return x * p.x + y * p.y + z * p.z - d; };
    for (int i = 0; i < vertices; ++i) EXPECT_LE(outside(vertex_of(hulls, h, i)), rounding);
    for (const Vector& p : points) EXPECT_LE(outside(p), error + rounding);
    // The plane goes through the farthest vertex, which is at most hull_error beyond the corners' mean, where they are at most as far
    // below.
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
      shell.push_back(i % 2 ? Vector{p.x, noise * p.y, p.z} : Vector{.5 * p.x, -noise * (p.x * p.x + p.z * p.z) - .1, .5 * p.z});
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
        grid.push_back(far + Vector{std::cos(turn) * x - std::sin(turn) * y, std::sin(turn) * x + std::cos(turn) * y, z});
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
      cylinder.push_back({std::round(1e6 * std::cos(M_PI * i / 10)) / 1e6, y, std::round(1e6 * std::sin(M_PI * i / 10)) / 1e6});
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
  const auto of = [&](const Vector& third) { return invalid([&] { add_mesh(world, {{{0, 0, 0}, {0, 0, 4}, third}, {{0, 1, 2}}}); }); };
  EXPECT_EQ(of({0, 0, 2}), "triangle 1 is thinner than a plane needs");
  EXPECT_EQ(of({1e-7, 0, 2}), "triangle 1 is thinner than a plane needs");
}

// --- Mass
//
// Masses are sums of products: of n terms, each of up to ten factors, the error is some (n + 10) u of the sum of the terms' sizes. Below, n
// is at most a hundred (a hull of twelve tetrahedra, six moments each) and the sums are 1 to 100: 1e-14 for a few terms, 1e-12 for hulls.

struct Body {
  double mass;
  Vector inertia;  // about the axes
  Pose<double> pose;
  Motion<double> motion;
};

Body body_of(const World<double>& world, int i) {
  const auto [x, y, z, w] = world.bodies.inverse_mass[i];
  return {1 / w, {1 / x, 1 / y, 1 / z}, world.bodies.pose[i], world.bodies.motion[i]};
}

const Pose<double> somewhere = {{1, 2, 3}, {.1, -.7, .5, .5}, 0};

template <class Add>
Body made(Add add, const Heaviness& heaviness, const Pose<double>& pose = somewhere, const Motion<double>& motion = {}) {
  World<double> world = make_world();
  begin_body(world, pose, motion);
  add(world);
  finish_body(world, heaviness);
  return body_of(world, 0);
}

void expect_pose(const Pose<double>& a, const Pose<double>& b) { EXPECT_EQ(std::memcmp(&a, &b, sizeof a), 0); }

TEST(RigidMass, OfSimpleShapesIsThatOfClosedForms) {
  // Sums and products of a few terms of one sign: each value is good to some ten roundings.
  const double near = 1e-14;
  const Body box = made([](auto& world) { add_box(world, {.5, 1, 1.5}); }, of_mass(12));
  expect_near(box.inertia, {4 + 9, 1 + 9, 1 + 4}, 12 * near);
  EXPECT_NEAR(box.mass, 12, 12 * near);
  const Body sphere = made([](auto& world) { add_sphere(world, 2); }, of_density(3));
  EXPECT_NEAR(sphere.mass, 32 * M_PI, 100 * near);
  expect_near(sphere.inertia, {1.6 * 32 * M_PI, 1.6 * 32 * M_PI, 1.6 * 32 * M_PI}, 200 * near);

  // A capsule, cut across into thin discs by Simpson's rule, whose error falls with the fourth power of the thickness but at the poles,
  // where the radius has an infinite slope: its square has none.
  const double half = .8, r = .5;
  const Body capsule = made([&](auto& world) { add_capsule(world, half, r); }, of_density(1));
  double mass = 0, along = 0, across = 0;
  const auto integrate = [&](double from, double to, auto radius_2) {
    constexpr int steps = 1000;
    for (int i = 0; i <= steps; ++i) {
      const double y = from + (to - from) * i / steps, weight = (i == 0 || i == steps ? 1 : i % 2 ? 4 : 2) * (to - from) / (3 * steps);
      const double disc = weight * M_PI * radius_2(y);
      mass += disc;
      along += disc * radius_2(y) / 2;
      across += disc * (radius_2(y) / 4 + y * y);
    }
  };
  integrate(-half, half, [&](double) { return r * r; });
  integrate(half, half + r, [&](double y) { return r * r - (y - half) * (y - half); });
  integrate(-half - r, -half, [&](double y) { return r * r - (y + half) * (y + half); });
  EXPECT_NEAR(capsule.mass, mass, 1e-11);
  expect_near(capsule.inertia, {across, along, across}, 1e-11);

  for (const Body& body : {box, sphere, capsule}) expect_pose(body.pose, somewhere);
}

TEST(RigidMass, OfAHullIsThatOfTheBox) {
  for (const Vector& offset : {Vector{0, 0, 0}, {3, -1, 2}}) {
    const Body hull = made(
        [&](auto& world) {
          std::vector<Vector> corners;
          for (int i = 0; i < 8; ++i) corners.push_back(offset + Vector{i % 2 ? .5 : -.5, i / 2 % 2 ? 1. : -1., i / 4 ? 1.5 : -1.5});
          add_hull(world, make_hull(world.hulls, corners));
        },
        of_mass(12), {{1, 2, 3}, no_rotation, 0});
    expect_near(hull.inertia, {13, 10, 5}, 1e-12);
    expect_near(hull.pose.position, Vector{1, 2, 3} + offset, 1e-14);
    EXPECT_EQ(hull.pose.orientation.w, 1);
  }
}

TEST(RigidMass, OfATetrahedronIsThatOfTheClosedForm) {
  // Of the corner of a cube of side 1, of mass 1: the means of x^2 and x y are 1/10 and 1/20, about the centre at 1/4 that is 3/80 and
  // -1/80. So the inertia has 6/80 on and 1/80 off its diagonal: 8/80 about the line from the corner through the centre, 5/80 across.
  const Body body = made(
      [](auto& world) {
        add_hull(world, make_hull(world.hulls, std::vector<Vector>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}));
      },
      of_density(6), no_offset);
  EXPECT_NEAR(body.mass, 1, 1e-14);
  expect_near(body.pose.position, {.25, .25, .25}, 1e-15);
  std::vector<double> inertia{body.inertia.x, body.inertia.y, body.inertia.z};
  std::ranges::sort(inertia);
  EXPECT_NEAR(inertia[0], 5. / 80, 1e-15);
  EXPECT_NEAR(inertia[1], 5. / 80, 1e-15);
  EXPECT_NEAR(inertia[2], 8. / 80, 1e-15);
}

// What a body does to a spin: R I R^T w.
Vector angular_momentum(const Body& body, const Vector& spin) {
  const Matrix3<double> turn = matrix_of(body.pose.orientation);
  const Vector local = transposed_times(turn, spin);
  return turn * Vector{body.inertia.x * local.x, body.inertia.y * local.y, body.inertia.z * local.z};
}

TEST(RigidMass, OfACompoundIsThatOfItsParts) {
  // An L of two boxes and a ball, that is turned and spins about its own origin.
  const Pose<double> poses[] = {{{0, 1, 0}, no_rotation, 0}, {{1, 0, .5}, {0, .6, 0, .8}, 0}, {{-1, -.5, 0}, no_rotation, 0}};
  const Motion<double> motion{{1, -2, 3}, {.5, 1, -1}, {}};
  World<double> world = make_world();
  begin_body(world, somewhere, motion);
  add_box(world, {.2, 1, .3}, poses[0]);
  add_box(world, {1, .2, .1}, poses[1]);
  add_sphere(world, .4, poses[2]);
  finish_body(world, of_density(2));
  const Body all = body_of(world, 0);

  // By the parallel-axis theorem, in the world: L = sum of R I R^T w + m d x (w x d), d from the common centre.
  const Body parts[] = {made(
                            [](auto& w) {
                              add_box(w, {.2, 1, .3});
                            },
                            of_density(2), poses[0]),
                        made(
                            [](auto& w) {
                              add_box(w, {1, .2, .1});
                            },
                            of_density(2), poses[1]),
                        made([](auto& w) { add_sphere(w, .4); }, of_density(2), poses[2])};
  const Matrix3<double> turn = matrix_of(somewhere.orientation);
  double mass = 0;
  Vector centre{0, 0, 0};
  for (const Body& part : parts) mass += part.mass, centre = centre + part.mass * part.pose.position;
  centre = 1 / mass * centre;
  EXPECT_NEAR(all.mass, mass, 1e-14);
  expect_near(all.pose.position, somewhere.position + turn * centre, 1e-14);
  expect_near(all.motion.velocity, motion.velocity + cross(motion.angular_velocity, turn * centre), 1e-14);
  for (const Vector& spin : {Vector{1, 0, 0}, {0, 1, 0}, {.3, -.5, 2}}) {
    Vector sum{0, 0, 0};
    for (const Body& part : parts) {
      const Vector d = part.pose.position - centre;
      sum = sum + angular_momentum(part, spin) + part.mass * cross(d, cross(spin, d));
    }
    expect_near(angular_momentum(all, turn * spin), turn * sum, 1e-13);
  }

  // Colliders stay where they are.
  for (int i = 0; i < 3; ++i) {
    const Pose<double>& local = world.colliders.local[i];
    for (const Vector& p : {Vector{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}})
      expect_near(exact_place(all.pose, exact_place(local, p)), exact_place(somewhere, exact_place(poses[i], p)), 1e-14);
  }
}

TEST(RigidMass, KeepsAxesThatArePrincipalAlready) {
  const Body dumbbell = made(
      [](auto& world) {
        add_sphere(world, .5, {{0, 2, 0}, no_rotation, 0});
        add_sphere(world, .5, {{0, -2, 0}, no_rotation, 0});
        add_capsule(world, 1.5, .1);
      },
      of_mass(1));
  expect_pose(dumbbell.pose, somewhere);
  const Body turned_cube = made([](auto& world) { add_box(world, {1, 1, 1}, {{0, 0, 0}, {.6, 0, 0, .8}, 0}); }, of_mass(1));
  expect_pose(turned_cube.pose, somewhere);
}

TEST(RigidMass, IsNoneOfStaticBodies) {
  World<double> world = make_world();
  begin_body(world, somewhere);
  add_box(world, {1, 2, 3}, {{4, 5, 6}, no_rotation, 0});
  finish_body(world, immovable);
  EXPECT_EQ(world.bodies.inverse_mass[0].w, 0);
  EXPECT_EQ(world.bodies.inverse_mass[0].x, 0);
  EXPECT_EQ(world.colliders.group[0], -1);
  expect_pose(world.bodies.pose[0], somewhere);
  begin_body(world, somewhere);
  EXPECT_EQ(invalid([&] { finish_body(world, of_mass(1)); }), "a body without a shape cannot move");
  add_plane(world);
  EXPECT_EQ(invalid([&] { finish_body(world, of_mass(1)); }), "a body with a plane or a mesh cannot move");
}

// --- Worlds

TEST(RigidWorlds, ArePaddedWithWhatChangesNothing) {
  World<double> world = make_world();
  for (int n = 0; n < 40; ++n) {
    const auto& [bodies, colliders, hulls] = world;
    ASSERT_EQ(bodies.count, n);
    for (const std::size_t size :
         {bodies.pose.size(), bodies.motion.size(), bodies.inverse_mass.size(), bodies.friction.size(), bodies.restitution.size()})
      EXPECT_EQ(size, padded(n));
    for (const std::size_t size : {colliders.kind.size(), colliders.body.size(), colliders.group.size(), colliders.local.size(),
                                   colliders.hull.size(), colliders.size.size()})
      EXPECT_EQ(size, padded(n));
    EXPECT_EQ(hulls.first_vertex.size(), padded(hulls.count + 1));
    EXPECT_EQ(hulls.vertex.size(), padded(hulls.first_vertex[hulls.count]));
    EXPECT_EQ(hulls.plane.size(), padded(hulls.first_face[hulls.count]));
    EXPECT_EQ(hulls.first_corner.size(), padded(hulls.first_face[hulls.count] + 1));
    EXPECT_EQ(hulls.corner.size(), padded(hulls.first_corner[hulls.first_face[hulls.count]]));
    EXPECT_EQ(hulls.centre.size(), padded(hulls.count));
    for (std::size_t i = n; i < padded(n); ++i) {
      expect_pose(bodies.pose[i], no_offset);
      expect_pose(colliders.local[i], no_offset);
      EXPECT_EQ(bodies.inverse_mass[i].w, 0);
      EXPECT_EQ(colliders.kind[i], static_cast<int>(Kind::sphere));
      EXPECT_EQ(colliders.hull[i], point_hull);
      EXPECT_EQ(colliders.group[i], -1);
      EXPECT_EQ(colliders.size[i].w, 0);
    }
    for (std::size_t i = hulls.count; i < padded(hulls.count + 1); ++i) EXPECT_EQ(hulls.first_vertex[i], hulls.first_vertex[hulls.count]);
    begin_body(world, no_offset);
    add_hull(world, make_hull(world.hulls, std::vector<Vector>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}));
    finish_body(world, of_mass(1));
    EXPECT_EQ(world.colliders.group[n], n);
  }
}

TEST(RigidWorlds, AreRoundedToFloat) {
  const Scene scene = load_scene("scenes/rigid/mesh_and_hulls.toml");
  const World<float> there_and_back = convert<float>(convert<double>(scene.world));
  const auto same = [](const auto& a, const auto& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0;
  };
  const auto &a = scene.world, &b = there_and_back;
  EXPECT_EQ(a.hulls.most_vertices, b.hulls.most_vertices);
  EXPECT_TRUE(a.bodies.count == b.bodies.count && a.colliders.count == b.colliders.count && a.hulls.count == b.hulls.count);
  EXPECT_TRUE(same(a.bodies.pose, b.bodies.pose) && same(a.bodies.motion, b.bodies.motion));
  EXPECT_TRUE(same(a.bodies.inverse_mass, b.bodies.inverse_mass) && same(a.bodies.friction, b.bodies.friction));
  EXPECT_TRUE(same(a.bodies.restitution, b.bodies.restitution));
  EXPECT_TRUE(same(a.colliders.kind, b.colliders.kind) && same(a.colliders.local, b.colliders.local));
  EXPECT_TRUE(same(a.colliders.size, b.colliders.size) && same(a.colliders.hull, b.colliders.hull));
  EXPECT_TRUE(same(a.colliders.body, b.colliders.body) && same(a.colliders.group, b.colliders.group));
  EXPECT_TRUE(same(a.hulls.vertex, b.hulls.vertex) && same(a.hulls.plane, b.hulls.plane) && same(a.hulls.corner, b.hulls.corner));
  EXPECT_TRUE(same(a.hulls.first_vertex, b.hulls.first_vertex) && same(a.hulls.first_face, b.hulls.first_face));
  EXPECT_TRUE(same(a.hulls.first_corner, b.hulls.first_corner) && same(a.hulls.centre, b.hulls.centre) && same(a.hulls.half, b.hulls.half));
}

// --- Generators

const Kit plain_kit = {{0, 0, 0}, 1, {}};

TEST(RigidGenerators, CountTheirBodies) {
  for (const int layers : {1, 2, 3, 8, 15}) {
    World<double> world = make_world();
    add_pyramid(world, plain_kit, layers);
    EXPECT_EQ(world.bodies.count, pyramid_bodies(layers));
  }
  for (const int courses : {1, 2, 5})
    for (const int bricks : {15, 16, 21}) {
      World<double> world = make_world();
      add_castle(world, plain_kit, courses, bricks);
      EXPECT_EQ(world.bodies.count, castle_bodies(courses, bricks));
    }
  EXPECT_EQ(castle_bodies(16, 42), 10000);
  EXPECT_EQ(pyramid_bodies(24), 4900);
}

// Boxes along the axes: none in another, and each on the ground or on another.
void expect_to_stand(const World<double>& world) {
  struct Block {
    Vector low, high;
  };
  std::vector<Block> blocks;
  for (int i = 0; i < world.colliders.count; ++i) {
    const Vector& p = world.bodies.pose[i].position;
    const Quad<double>& half = world.colliders.size[i];
    EXPECT_EQ(world.bodies.pose[i].orientation.w, 1);
    blocks.push_back({p - Vector{half.x, half.y, half.z}, p + Vector{half.x, half.y, half.z}});
  }
  std::ranges::sort(blocks, {}, [](const Block& b) { return b.low.x; });
  const double near = 1e-12;  // positions of some tens of metres, of a few roundings
  std::vector<char> stands(blocks.size());
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    stands[i] |= std::abs(blocks[i].low.y) <= near;
    for (std::size_t j = i + 1; j < blocks.size() && blocks[j].low.x < blocks[i].high.x - near; ++j) {
      const Block &a = blocks[i], &b = blocks[j];
      if (!(a.low.z < b.high.z - near && b.low.z < a.high.z - near)) continue;
      EXPECT_FALSE(a.low.y < b.high.y - near && b.low.y < a.high.y - near) << "at " << b.low.x << ' ' << b.low.y << ' ' << b.low.z;
      stands[i] |= std::abs(a.low.y - b.high.y) <= near;
      stands[j] |= std::abs(b.low.y - a.high.y) <= near;
    }
  }
  EXPECT_EQ(std::ranges::count(stands, false), 0);
}

TEST(RigidGenerators, BuildWhatStands) {
  const auto made = [](auto add) {
    World<double> world = make_world();
    add(world);
    return world;
  };
  expect_to_stand(made([](auto& w) { add_pyramid(w, plain_kit, 9); }));
  expect_to_stand(made([](auto& w) { add_wall(w, plain_kit, 20, 50); }));
  expect_to_stand(made([](auto& w) { add_castle(w, plain_kit, 16, 42); }));
  expect_to_stand(made([](auto& w) { add_castle(w, plain_kit, 3, 15); }));
  expect_to_stand(made([](auto& w) { add_stack(w, plain_kit, 10, {.5, .25, .5}); }));
  expect_to_stand(made([](auto& w) { add_dominoes(w, plain_kit, 10); }));
}

TEST(RigidGenerators, PutPyramidsWhereOthersDo) {
  World<double> world = make_world();
  add_pyramid(world, plain_kit, 3);
  const auto at = [&](int i) { return world.bodies.pose[i].position; };
  expect_near(at(0), {-1.575, .5, -1.575}, 1e-15);
  expect_near(at(5), {-.525, .5, .525}, 1e-15);
  expect_near(at(9), {-1.05, 1.5, -1.05}, 1e-15);
  expect_near(at(13), {-.525, 2.5, -.525}, 1e-15);
}

TEST(RigidGenerators, ChanceIsTheSameOnEveryMachine) {
  // SplitMix64's first two numbers of this seed, as published, are 6457827717110365317 and 3203168211198807973.
  World<double> world = make_world();
  add_pit(world, plain_kit, Assortment::boxes, 1, 11, 1.2, 1234567);
  const Vector& p = world.bodies.pose[pit_walls].position;
  EXPECT_NEAR(p.x, -8.5 + .2 * (6457827717110365317 * 0x1p-64 - .5), 1e-14);
  EXPECT_NEAR(p.z, -8.5 + .2 * (3203168211198807973 * 0x1p-64 - .5), 1e-14);
  EXPECT_EQ(p.y, 1.2);
}

TEST(RigidGenerators, FillPits) {
  World<double> world = make_world();
  add_pit(world, plain_kit, Assortment::hulls, 200, 9, 1, 1);
  ASSERT_EQ(world.bodies.count, 205);
  EXPECT_EQ(world.hulls.count, 3 + 64);
  // The walls begin 8 m from the middle.
  EXPECT_NEAR(world.bodies.pose[2].position.x - world.colliders.size[2].x, 8, 1e-14);
  EXPECT_NEAR(world.bodies.pose[4].position.z - world.colliders.size[4].z, 8, 1e-14);
  for (int h = 3; h < 67; ++h) {
    const int count = world.hulls.vertices(h);
    EXPECT_TRUE(count >= 12 && count <= 24) << "all points of an ellipsoid are corners";
    for (int i = 0; i < count; ++i) {
      EXPECT_LE(length(vertex_of(world.hulls, h, i)), .75 + 1e-15);
      EXPECT_GE(length(vertex_of(world.hulls, h, i)), .45 - 1e-15);
      for (int k = 0; k < i; ++k) EXPECT_GE(length(vertex_of(world.hulls, h, i) - vertex_of(world.hulls, h, k)), .1);
    }
  }
  World<double> boxes = make_world();
  add_pit(boxes, plain_kit, Assortment::boxes, 300, 11, 1.2, 1);
  EXPECT_NEAR(boxes.bodies.pose[2].position.x - boxes.colliders.size[2].x, 10, 1e-14);
  for (int i = 0; i < 300; ++i) {
    const Vector& p = boxes.bodies.pose[5 + i].position;
    EXPECT_LE(std::abs(p.x - 1.7 * (i % 11 - 5)), .1 + 1e-14);
    EXPECT_LE(std::abs(p.z - 1.7 * (i / 11 % 11 - 5)), .1 + 1e-14);
    EXPECT_NEAR(p.y, 1.2 + 1.7 * (i / 121), 1e-14);
    EXPECT_EQ(boxes.colliders.size[5 + i].x, (std::array{.5, .3, .4, .6})[i % 4]);
  }
}

ExactShape exact_collider(const World<double>& world, int i) {
  const Quad<double>& size = world.colliders.size[i];
  const int hull = world.colliders.hull[i];
  std::vector<Vector> vertices;
  for (int k = 0; k < world.hulls.vertices(hull); ++k) {
    const Vector v = vertex_of(world.hulls, hull, k);
    const Vector local = exact_place(world.colliders.local[i], {size.x * v.x, size.y * v.y, size.z * v.z});
    vertices.push_back(exact_place(world.bodies.pose[world.colliders.body[i]], local));
  }
  return exact_shape(vertices, faces_of(world.hulls, hull), size.w);
}

// Bodies are counted that are farther from the border than two bodies are wide; of them, each overlaps another with the probability asked
// for, but that kinds differ in size, and 1 - exp(-n E) bends: of kinds with E up to a third off its mean, n E = .69, .015 at most. The
// rest is chance: three standard deviations of m bodies, doubled, since neighbours overlap together.
TEST(RigidGenerators, SoupsAreAsDenseAsAsked) {
  for (const auto& [assortment, overlapping] :
       {std::pair(Assortment::rounds, .1), {Assortment::boxes, .5}, {Assortment::hulls, .5}, {Assortment::mixed, .1}}) {
    World<double> world = make_world();
    constexpr int count = 3000;
    add_soup(world, plain_kit, assortment, count, overlapping, 5);
    std::vector<ExactShape> shapes;
    double border = 0;
    for (int i = 0; i < count; ++i) {
      shapes.push_back(exact_collider(world, i));
      for (const Vector& v : shapes.back().vertex) border = std::max({border, std::abs(v.x), std::abs(v.y), std::abs(v.z)});
    }
    std::vector<char> overlaps(count);
    for (int i = 0; i < count; ++i)
      for (int k = 0; k < i; ++k) {
        const Vector apart = world.bodies.pose[i].position - world.bodies.pose[k].position;
        if (dot(apart, apart) > 1.9 * 1.9 || (overlaps[i] && overlaps[k])) continue;  // the largest reach .92 m from their middle
        if (exact_separation(shapes[i], shapes[k]).separation <= 0) overlaps[i] = overlaps[k] = true;
      }
    int inner = 0, hits = 0;
    for (int i = 0; i < count; ++i) {
      const Vector& p = world.bodies.pose[i].position;
      if (std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) > border - 2 * .92 - .92) continue;
      ++inner;
      hits += overlaps[i];
    }
    EXPECT_GT(inner, 500);
    const double deviation = std::sqrt(overlapping * (1 - overlapping) / inner);
    EXPECT_NEAR(static_cast<double>(hits) / inner, overlapping, .015 + 6 * deviation) << static_cast<int>(assortment);
  }
}

// --- Scenes. Run from the root of the repository, as `make test` does.

int movable(const World<float>& world) {
  int count = 0;
  for (int i = 0; i < world.bodies.count; ++i) count += world.bodies.inverse_mass[i].w > 0;
  return count;
}

TEST(RigidScenes, OfTheRepositoryLoad) {
  const std::map<std::string, int> expected{
      {"assorted", 307},    {"billiard", 16},        {"box_pit_4000", 4000},  {"boxes_100k", 100000},
      {"castle", 10000},    {"castle_hit", 10001},   {"degenerate", 44},      {"dominoes_1000", 1001},
      {"four_bodies", 3},   {"hull_pit_2000", 2000}, {"hull_soup", 5000},     {"mesh_and_hulls", 500},
      {"pyramid_15", 1240}, {"pyramid_24", 4900},    {"rounds_20000", 20000}, {"slope", 5},
      {"soup_1", 10000},    {"soup_10", 10000},      {"soup_50", 10000},      {"stack_10", 10},
      {"top", 1},           {"wall", 1000},
  };
  std::map<std::string, int> found;
  for (const auto& file : std::filesystem::directory_iterator("scenes/rigid")) {
    if (file.path().extension() != ".toml") continue;
    EXPECT_EQ(verify::domain_of_scene(file.path().string()).name, "rigid");
    EXPECT_LT(std::filesystem::file_size(file.path()), 10'000u);
    const Scene scene = load_scene(file.path().string());
    found[scene.name] = movable(scene.world);
    for (int i = 0; i < scene.world.colliders.count; ++i) {
      const Colliders<float>& c = scene.world.colliders;
      EXPECT_TRUE(i == 0 || c.body[i] >= c.body[i - 1]);
      EXPECT_EQ(c.group[i], scene.world.bodies.inverse_mass[c.body[i]].w > 0 ? c.body[i] : -1);
    }
  }
  EXPECT_EQ(found, expected);
}

struct RigidSceneTest : TemporaryFolder {
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

const std::string head = "kind = \"rigid\"\nframes = 9\n";
const std::string ball = "[[body]]\nsphere = 0.5\nmass = 2\n";

TEST_F(RigidSceneTest, HareIsWhatItsScriptWrites) {
  const Mesh mesh = read_obj("scenes/rigid/hare.obj");
  EXPECT_EQ(mesh.triangles.size(), 5120u);
  require_closed(mesh, "hare");
  if (std::system("python3 -c '' 2>/dev/null") != 0) GTEST_SKIP() << "no python3";
  std::filesystem::copy_file("scenes/rigid/hare.py", path("hare.py"));
  ASSERT_EQ(std::system(("python3 " + path("hare.py")).c_str()), 0);
  EXPECT_TRUE(read_bytes(path("hare.obj")) == read_bytes("scenes/rigid/hare.obj"));
}

TEST_F(RigidSceneTest, SaysWhatItSays) {
  const Scene scene = load(
      "kind = \"rigid\"\nframes = 7\nsettle = 5\ntime_step = 0.01\niterations = 3\ngravity = [1, 2, 3]\nfriction = 0.25\nrestitution = "
      "0.5\n"
      "[[hull]]\nname = \"gem\"\npoints = [[-1, -1, -1], [1, 1, -1], [1, -1, 1], [-1, 1, 1]]\n"
      "[[body]]\nplane = [0, 0, -2]\nposition = [4, 5, 6]\n"
      "[[body]]\nhull = \"gem\"\ndensity = 3\nposition = [1, 2, 3]\nvelocity = [4, 5, 6]\nangular_velocity = [7, 8, 9]\nfriction = 0.75\n"
      "restitution = 0.125\norientation = [0, 0, 0.6, 0.8002]\n"
      "[[body]]\nmass = 2\n[[body.part]]\nsphere = 0.5\nposition = [0, 1, 0]\n"
      "[[body.part]]\ncapsule = { half = 2, radius = 0.5 }\nposition = [0, -1, 0]\n[[body.part]]\nbox = [1, 2, 3]\n");
  EXPECT_EQ(scene.name, "a");
  EXPECT_EQ(scene.path, path("a.toml"));
  EXPECT_EQ(scene.frames, 7);
  EXPECT_EQ(scene.settle, 5);
  EXPECT_EQ(scene.iterations, 3);
  EXPECT_EQ(scene.time_step, .01);
  expect_near(scene.gravity, {1, 2, 3}, 0);
  const auto& [bodies, colliders, hulls] = scene.world;
  ASSERT_EQ(bodies.count, 3);
  ASSERT_EQ(colliders.count, 5);

  EXPECT_EQ(colliders.kind[0], static_cast<int>(Kind::plane));
  EXPECT_EQ(colliders.hull[0], -1);
  EXPECT_EQ(bodies.pose[0].position.y, 5);
  EXPECT_EQ(bodies.friction[0], .25f);
  EXPECT_EQ(bodies.restitution[0], .5f);
  const Vector3<float> normal = matrix_of(colliders.local[0].orientation) * Vector3<float>{0, 1, 0};
  expect_near({normal.x, normal.y, normal.z}, {0, 0, -1}, 1e-7);

  EXPECT_EQ(colliders.kind[1], static_cast<int>(Kind::hull));
  EXPECT_EQ(hulls.vertices(colliders.hull[1]), 4);
  EXPECT_EQ(bodies.pose[1].position.z, 3);
  EXPECT_EQ(bodies.pose[1].orientation.z, static_cast<float>(.6 / std::sqrt(.36 + .8002 * .8002))) << "made a unit";
  EXPECT_EQ(bodies.motion[1].velocity.y, 5);
  EXPECT_EQ(bodies.motion[1].angular_velocity.z, 9);
  EXPECT_EQ(bodies.friction[1], .75f);
  EXPECT_EQ(bodies.restitution[1], .125f);
  EXPECT_NEAR(bodies.inverse_mass[1].w, 1 / (3 * 8. / 3), 1e-7) << "a third of the cube around it";

  EXPECT_EQ(bodies.inverse_mass[2].w, .5f);
  const Kind kinds[] = {Kind::sphere, Kind::capsule, Kind::box};
  for (int i = 0; i < 3; ++i) EXPECT_EQ(colliders.kind[2 + i], static_cast<int>(kinds[i]));
  EXPECT_EQ(colliders.size[2].w, .5f);
  EXPECT_EQ(colliders.size[3].y, 2);
  EXPECT_EQ(colliders.size[4].z, 3);
  EXPECT_NEAR(colliders.local[2].position.y - colliders.local[3].position.y, 2, 1e-6);
}

TEST_F(RigidSceneTest, HasDefaults) {
  const Scene scene = load(head + "[[body]]\nsphere = 0.5\n");
  EXPECT_EQ(scene.time_step, 1. / 60);
  EXPECT_EQ(scene.iterations, 10);
  expect_near(scene.gravity, {0, -9.81, 0}, 0);
  EXPECT_EQ(scene.world.bodies.friction[0], .5f);
  EXPECT_EQ(scene.world.bodies.restitution[0], 0);
  EXPECT_EQ(scene.world.bodies.inverse_mass[0].w, 0) << "static";
  EXPECT_EQ(scene.world.bodies.pose[0].orientation.w, 1);
  EXPECT_EQ(movable(load(head + "[[castle]]\n[[pit]]\nof = \"rounds\"\ncount = 5\n").world), 10005);
}

TEST_F(RigidSceneTest, PlanesFaceAnyWay) {
  for (const Vector& n : {Vector{0, 1, 0}, {0, -1, 0}, {1, 0, 0}, {0, 0, -1}, {1, -2, 3}, {1e-4, -1, 0}, {1e-6, -1, 0}, {0, -1, 3e-3}}) {
    const std::string normal = std::to_string(n.x) + ", " + std::to_string(n.y) + ", " + std::to_string(n.z);
    const Scene scene = load(head + "[[body]]\nplane = [" + normal + "]\n");
    const World<double> world = convert<double>(scene.world);
    const Vector found = matrix_of(world.colliders.local[0].orientation) * Vector{0, 1, 0};
    // The quaternion's numbers are rounded to float, by 6e-8 of each; a component of what they turn has at most eight products of them.
    expect_near(found, 1 / length(n) * n, 8 * 6e-8);
  }
}

TEST_F(RigidSceneTest, TakesHullsAndMeshesOfFiles) {
  const std::string corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
  write_bytes(path("a.obj"), corners + "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  const Scene hull = load(head + "[[hull]]\nname = \"a\"\nfile = \"a.obj\"\n[[body]]\nhull = \"a\"\nmass = 1\n");
  EXPECT_EQ(hull.world.hulls.vertices(3), 4);
  const Scene mesh = load(head + "[[body]]\nmesh = \"a.obj\"\nposition = [1, 0, 0]\n");
  EXPECT_EQ(mesh.world.colliders.count, 4);
  EXPECT_EQ(mesh.world.colliders.kind[3], static_cast<int>(Kind::triangle));

  const std::string body = "[[body]]\nmesh = \"a.obj\"\n";
  EXPECT_EQ(error(head + "[[body]]\nmesh = \"b.obj\"\n"), "b.obj: cannot be read: No such file or directory");
  write_bytes(path("a.obj"), corners + "f 1 3 2\nf 1 2 4\nf 1 4 3\n");
  EXPECT_EQ(error(head + body), "a.obj: the edge of points 2 and 3 is in 1 triangle, expected two: a closed mesh");
  write_bytes(path("a.obj"), corners + "f 1 2 9\n");
  EXPECT_EQ(error(head + body), "a.obj:5: f: point 9 of 4");
  write_bytes(path("a.obj"), "v 0 0 0\nv 2e5 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  EXPECT_EQ(error(head + body), "a.obj: point 2 is not within 1e5 m of the origin");
  write_bytes(path("a.obj"), "v 0 0 0\nv 1 0 0\nv 0.5 0 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  EXPECT_EQ(error(head + body), "a.obj: triangle 1 is thinner than a plane needs");
  EXPECT_EQ(error(head + "[[hull]]\nname = \"a\"\nfile = \"a.obj\"\n[[body]]\nhull = \"a\"\nmass = 1\n"), "a.obj: the points are flat");
}

TEST_F(RigidSceneTest, RefusesWhatIsNoScene) {
  EXPECT_EQ(error_of([&] { load_scene(path("none.toml")); }), path("none.toml") + ": cannot be read: No such file or directory");
  EXPECT_EQ(error_of([&] { load_scene(folder); }), folder + ": is a directory, expected a file");
  EXPECT_EQ(error("kind = rigid\n").rfind("a.toml:1:8: ", 0), 0u);
  EXPECT_EQ(error("kind = \"cloth\"\nframes = 1\n"), "a.toml:1:8: kind: expected \"rigid\"");
  EXPECT_EQ(error("kind = \"rigid\"\n" + ball), "a.toml:1:1: frames is missing");
  EXPECT_EQ(error(head), "a.toml:1:1: no body in it");
  EXPECT_EQ(error(head + "step = 1\n"),
            "a.toml:3:1: unknown key step, expected one of: kind, frames, settle, time_step, iterations, gravity, friction, restitution, "
            "hull, body, "
            "pyramid, stack, wall, castle, dominoes, pit, soup");
  EXPECT_EQ(error(head + "[body]\nsphere = 1\n"), "a.toml:3:1: body: expected one or more tables [[body]]");
}

TEST_F(RigidSceneTest, RefusesWrongValues) {
  const auto with = [&](const std::string& line) { return error(head + line + '\n' + ball); };
  for (const char* value : {"0", "-1", "2", "nan", "inf", "\"1\""})
    EXPECT_EQ(with("time_step = " + std::string(value)), "a.toml:3:13: time_step: expected a number from 1e-6 to 1, in s") << value;
  for (const char* value : {"0", "1.5", "-1", "2147483648"})
    EXPECT_EQ(with("iterations = " + std::string(value)), "a.toml:3:14: iterations: expected a whole number from 1 to 2147483647");
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
  EXPECT_EQ(with("capsule = { half = 1, radius = 1, axis = 2 }"), "a.toml:4:35: unknown key axis, expected one of: half, radius");
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
  EXPECT_EQ(with("mass = 1\n[[body.part]]\nposition = [0, 0, 0]"), "a.toml:5:1: sphere, capsule, box, hull, plane or mesh is missing");
  EXPECT_EQ(with("[[body.part]]\nsphere = 1\nmass = 1"),
            "a.toml:6:1: unknown key mass, expected one of: sphere, capsule, box, hull, plane, mesh, position, orientation");
  EXPECT_EQ(with("colour = 1"),
            "a.toml:4:1: unknown key colour, expected one of: sphere, capsule, box, hull, plane, mesh, part, position, orientation, "
            "velocity, angular_velocity, mass, density, friction, restitution");

  const auto of = [&](const std::string& line) { return with("sphere = 1\n" + line); };
  EXPECT_EQ(of("position = [0, nan, 0]"), "a.toml:5:16: position: expected three finite numbers [x, y, z] in m");
  EXPECT_EQ(of("position = [0, 0, -2e6]"), "a.toml:5:12: position: expected numbers of at most 1e6, in m");
  const std::string unit = "orientation: expected a unit quaternion [x, y, z, w], its square 1 to within 0.001";
  for (const char* value : {"1", "[0, 0, 1]", "[0, 0, 0, 0]", "[0, 0, 0, 1.001]", "[0.5, 0.5, 0.5, 0.498]", "[0, 0, 0, 1e18]"})
    EXPECT_EQ(of("orientation = " + std::string(value)), "a.toml:5:15: " + unit) << value;
  EXPECT_EQ(of("orientation = [0, 0, nan, 1]"), "a.toml:5:22: " + unit);
  for (const char* value : {"0", "-1", "nan", "1e10", "\"1\""})
    EXPECT_EQ(of("mass = " + std::string(value)), "a.toml:5:8: mass: expected a number from 1e-6 to 1e9, in kg");
  for (const char* value : {"0", "-1", "nan", "1e7"})
    EXPECT_EQ(of("density = " + std::string(value)), "a.toml:5:11: density: expected a number from 1e-3 to 1e6, in kg/m^3");
  EXPECT_EQ(of("mass = 1\ndensity = 1"), "a.toml:6:11: density: expected either mass or density");
  EXPECT_EQ(of("velocity = [0, 1, 0]"), "a.toml:5:12: velocity: expected none of a body without mass or density, which never moves");
  EXPECT_EQ(of("mass = 1\nangular_velocity = [0, 1e7, 0]"), "a.toml:6:20: angular_velocity: expected numbers of at most 1e6, in rad/s");
  EXPECT_EQ(of("mass = 1\nfriction = -1"), "a.toml:6:12: friction: expected a number from 0 to 100");
  EXPECT_EQ(with("plane = [0, 1, 0]\nmass = 1"), "a.toml:5:8: mass: expected none of a body with a plane or a mesh, which never moves");
  EXPECT_EQ(with("mesh = \"a.obj\"\ndensity = 1"),
            "a.toml:5:11: density: expected none of a body with a plane or a mesh, which never moves");
  EXPECT_EQ(with("density = 1\n[[body.part]]\nplane = [0, 1, 0]"),
            "a.toml:4:11: density: expected none of a body with a plane or a mesh, which never moves");
  const std::string needle = "[[hull]]\nname = \"a\"\npoints = [[0, 0, 0], [1e-4, 0, 0], [0, 1e-9, 0], [0, 0, 1e-9]]\n";
  EXPECT_EQ(error(head + needle + "[[body]]\nhull = \"a\"\ndensity = 1e-3\n").rfind("a.toml:6:1: a mass or an inertia of ", 0), 0u);
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
  EXPECT_EQ(of("[[0, 0, 0], [1, 0, inf]]"), "a.toml:5:22: points: expected three numbers [x, y, z] from -1e5 to 1e5, in m");
  EXPECT_EQ(of("[[0, 0, 0], 1]"), "a.toml:5:22: points: expected three numbers [x, y, z] from -1e5 to 1e5, in m");
  EXPECT_EQ(of("[[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]"), "a.toml:5:10: points: the points are flat");
  EXPECT_EQ(of("[[1, 1, 1], [1, 1, 1], [1, 1, 1], [1, 1, 1]]"), "a.toml:5:10: points: expected points 1e-4 m apart, or more");
  EXPECT_EQ(of("[[5000, 0, 0], [5001, 0, 0], [5000, 1, 0], [5000, 0, 1]]"),
            "a.toml:5:10: points: expected points around the origin, not farther from it than 1000 times their extent");
  const std::string good = "[[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]";
  EXPECT_EQ(of(good + "\n[[hull]]\nname = \"a\"\npoints = " + good), "a.toml:7:8: name: expected another: there is a hull \"a\" above");
}

TEST_F(RigidSceneTest, RefusesWrongGenerators) {
  const auto with = [&](const std::string& lines) { return error(head + lines); };
  EXPECT_EQ(with("[[pyramid]]\n"), "a.toml:3:1: layers is missing");
  EXPECT_EQ(with("[[pyramid]]\nlayers = 0\n"), "a.toml:4:10: layers: expected a whole number from 1 to 67108864");
  EXPECT_EQ(with("[[pyramid]]\nlayers = 2\ncount = 1\n"), "a.toml:5:1: unknown key count, expected one of: layers, position, mass");
  EXPECT_EQ(with("[pyramid]\nlayers = 2\n"), "a.toml:3:1: pyramid: expected one or more tables [[pyramid]]");
  EXPECT_EQ(with("[[stack]]\ncount = 2\n"), "a.toml:3:1: box is missing");
  EXPECT_EQ(with("[[stack]]\ncount = 2\nbox = [0, 1, 1]\n"),
            "a.toml:5:7: box: expected three numbers from 1e-4 to 1e5, in m");
  EXPECT_EQ(with("[[wall]]\ncourses = 2\nbricks = 1.5\n"), "a.toml:5:10: bricks: expected a whole number from 1 to 67108864");
  EXPECT_EQ(with("[[castle]]\nbricks = 14\n"), "a.toml:4:10: bricks: expected a whole number from 15 to 67108864");
  EXPECT_EQ(with("[[castle]]\nmass = 0\n"), "a.toml:4:8: mass: expected a number from 1e-6 to 1e9, in kg");
  EXPECT_EQ(with("[[castle]]\nposition = [0, 1]\n"), "a.toml:4:12: position: expected three finite numbers [x, y, z] in m");
  EXPECT_EQ(with("[[dominoes]]\ncount = -1\n"), "a.toml:4:9: count: expected a whole number from 1 to 67108864");
  for (const char* value : {"\"sand\"", "1", "[\"boxes\"]"})
    EXPECT_EQ(with("[[pit]]\ncount = 1\nof = " + std::string(value)),
              "a.toml:5:6: of: expected \"boxes\", \"rounds\", \"hulls\" or \"mixed\"");
  EXPECT_EQ(with("[[pit]]\nof = \"boxes\"\n"), "a.toml:3:1: count is missing");
  EXPECT_EQ(with("[[pit]]\nof = \"boxes\"\ncount = 1\nacross = 0\n"), "a.toml:6:10: across: expected a whole number from 1 to 10000");
  EXPECT_EQ(with("[[pit]]\nof = \"boxes\"\ncount = 1\nfrom = 0\n"), "a.toml:6:8: from: expected a number from 1e-4 to 1e5, in m");
  EXPECT_EQ(with("[[pit]]\nof = \"boxes\"\ncount = 1\nseed = -1\n"),
            "a.toml:6:8: seed: expected a whole number from 0 to 9223372036854775807");
  for (const char* value : {"0", "1", "nan", "-0.5", "\"half\""})
    EXPECT_EQ(with("[[soup]]\nof = \"boxes\"\ncount = 1\noverlapping = " + std::string(value)),
              "a.toml:6:15: overlapping: expected a number from 1e-6 to 0.999");
}

TEST_F(RigidSceneTest, RefusesWhatIsTooBig) {
  EXPECT_EQ(error(head + "[[pyramid]]\nlayers = 1000000\n"), "a.toml:3:1: 3.333338333e+17 bodies, expected at most 67108864 in all");
  EXPECT_EQ(error(head + "[[dominoes]]\ncount = 60000000\n[[pit]]\nof = \"boxes\"\ncount = 67108864\n").rfind("a.toml:", 0), 0u);
  const Limit limit(RLIMIT_AS, address_space() + 500'000'000);
  const std::string message = error(head + "[[dominoes]]\ncount = 10000000\n");
  EXPECT_EQ(message.rfind("a.toml:3:1: 10000000 bodies needs ", 0), 0u) << message;
}

TEST(RigidMemory, CountsWhatAWorldAllocates) {
  const auto bytes = [](const auto&... arrays) { return (0. + ... + static_cast<double>(arrays.capacity() * sizeof(arrays[0]))); };
  const auto bytes_of = [&](const auto& world) {
    const auto& [b, c, h] = world;
    return bytes(b.pose, b.motion, b.inverse_mass, b.friction, b.restitution) + bytes(c.kind, c.body, c.group, c.local, c.hull, c.size) +
           bytes(h.vertex, h.plane, h.corner, h.first_vertex, h.first_face, h.first_corner, h.centre, h.half);
  };
  World<double> bodies = make_world(), mesh = make_world();
  add_pyramid(bodies, plain_kit, 20);
  begin_body(mesh, no_offset);
  add_mesh(mesh, read_obj("scenes/rigid/hare.obj"));
  const double of_bodies = bytes_of(bodies) + bytes_of(convert<float>(bodies));
  const double of_mesh = bytes_of(mesh) + bytes_of(convert<float>(mesh));
  EXPECT_LE(of_bodies, making_bytes(pyramid_bodies(20), 0));
  EXPECT_GE(of_bodies, making_bytes(pyramid_bodies(20), 0) / 4) << "what is needed in making, too, but not out of all proportion";
  EXPECT_LE(of_mesh, making_bytes(0, 5120));
  EXPECT_GE(of_mesh, making_bytes(0, 5120) / 4);
}

// --- Frames

struct Frame {
  std::vector<Vector> points;
  std::vector<std::vector<int>> cells;
  std::vector<int> body;
  std::vector<float> speed;
};

// Reads what ParaView would, and expects nothing else in the file.
Frame read_vtk(const std::string& bytes) {
  Frame frame;
  std::size_t at = 0;
  const auto line = [&] {
    const std::size_t end = bytes.find('\n', at);
    const std::string text = bytes.substr(at, end - at);
    at = end + 1;
    return text;
  };
  const auto word = [&] {
    std::uint32_t x = 0;
    for (int k = 0; k < 4; ++k) x = x << 8 | static_cast<unsigned char>(bytes.at(at++));
    return x;
  };
  const auto real = [&] { return std::bit_cast<float>(word()); };
  for (const char* text : {"# vtk DataFile Version 3.0", "Lockstep rigid bodies", "BINARY", "DATASET POLYDATA"}) EXPECT_EQ(line(), text);
  int points = 0, cells = 0, words = 0;
  EXPECT_EQ(std::sscanf(line().c_str(), "POINTS %d float", &points), 1);
  for (int i = 0; i < points; ++i) {
    const double x = real(), y = real(), z = real();
    frame.points.push_back({x, y, z});
  }
  EXPECT_EQ(line(), "");
  EXPECT_EQ(std::sscanf(line().c_str(), "POLYGONS %d %d", &cells, &words), 2);
  for (int i = 0; i < cells; ++i) {
    frame.cells.emplace_back(word());
    words -= 1 + static_cast<int>(frame.cells.back().size());
    for (int& corner : frame.cells.back()) {
      corner = static_cast<int>(word());
      EXPECT_TRUE(corner >= 0 && corner < points);
    }
  }
  EXPECT_EQ(words, 0);
  EXPECT_EQ(line(), "");
  EXPECT_EQ(line(), "CELL_DATA " + std::to_string(cells));
  EXPECT_EQ(line(), "SCALARS body int 1");
  EXPECT_EQ(line(), "LOOKUP_TABLE default");
  for (int i = 0; i < cells; ++i) frame.body.push_back(static_cast<int>(word()));
  EXPECT_EQ(line(), "");
  EXPECT_EQ(line(), "SCALARS speed float 1");
  EXPECT_EQ(line(), "LOOKUP_TABLE default");
  for (int i = 0; i < cells; ++i) frame.speed.push_back(real());
  EXPECT_EQ(line(), "");
  EXPECT_EQ(at, bytes.size());
  return frame;
}

// The volume inside the cells of a body, if they are counterclockwise from outside, by the divergence theorem.
double volume_of(const Frame& frame, int body) {
  double sum = 0;
  for (std::size_t c = 0; c < frame.cells.size(); ++c) {
    if (frame.body[c] != body) continue;
    const auto& cell = frame.cells[c];
    for (std::size_t k = 1; k + 1 < cell.size(); ++k)
      sum += dot(frame.points[cell[0]], cross(frame.points[cell[k]], frame.points[cell[k + 1]])) / 6;
  }
  return sum;
}

TEST_F(RigidSceneTest, WritesFramesForParaView) {
  write_bytes(path("a.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  const Scene scene =
      load(head +
           "[[hull]]\nname = \"a\"\nfile = \"a.obj\"\n"
           "[[body]]\nbox = [0.5, 1, 1.5]\nposition = [1, 2, 3]\norientation = [0, 0.6, 0, 0.8]\nmass = 1\n"
           "velocity = [2, 3, 6]\n"
           "[[body]]\nsphere = 0.5\nposition = [-1, 2, 0]\n[[body]]\ncapsule = { half = 2, radius = 0.5 }\n"
           "[[body]]\nhull = \"a\"\nmass = 1\n[[body]]\nmesh = \"a.obj\"\n[[body]]\nplane = [0, 1, 0]\nposition = [0, -3, 0]\n");
  write_vtk(path("a.vtk"), scene.world);
  const Frame frame = read_vtk(read_bytes(path("a.vtk")));
  EXPECT_EQ(std::ranges::count(frame.body, 0), 6);
  EXPECT_EQ(std::ranges::count(frame.body, 3), 4);
  EXPECT_EQ(std::ranges::count(frame.body, 4), 4);
  EXPECT_EQ(std::ranges::count(frame.body, 5), 1);
  for (std::size_t c = 0; c < frame.cells.size(); ++c) EXPECT_EQ(frame.speed[c], frame.body[c] == 0 ? 7 : 0);
  // Points are floats, of some metres.
  EXPECT_NEAR(volume_of(frame, 0), 6, 1e-5);
  EXPECT_NEAR(volume_of(frame, 3), 1. / 6, 1e-6);
  EXPECT_NEAR(volume_of(frame, 4), 1. / 6, 1e-6);
  // Corners are on the sphere: less than it, and more than half.
  const double sphere = volume_of(frame, 1), capsule = volume_of(frame, 2);
  EXPECT_LT(sphere, M_PI / 6);
  EXPECT_GT(sphere, M_PI / 12);
  EXPECT_NEAR(capsule - sphere, 4 * .25 * 4 * std::sin(M_PI / 4), 1e-5) << "a prism of eight sides";
  for (const int corner : frame.cells.back()) EXPECT_EQ(frame.points[corner].y, -3) << "the plane";
  EXPECT_EQ(error_of([&] { write_vtk(path("none/a.vtk"), scene.world); }),
            path("none/a.vtk") + ": cannot be written: No such file or directory");
}

}  // namespace
}  // namespace lockstep::rigid
