// Masses and inertias of bodies are those of closed forms, and worlds are padded and rounded as their contract says.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "common/convert.h"
#include "common/rigid/scene.h"
#include "tests/rigid_worlds.h"

namespace lockstep::rigid::worlds {
namespace {

// Masses are sums of products. With n terms of up to ten factors each, the error is about (n + 10) u of the sum of the
// terms' magnitudes. Below, n is at most a hundred (a hull of twelve tetrahedra, six moments each), and the sums are 1
// to 100. The bounds are 1e-14 for a few terms and 1e-12 for hulls.

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
Body made(Add add, const Heaviness& heaviness, const Pose<double>& pose = somewhere,
          const Motion<double>& motion = {}) {
  World<double> world = make_world();
  begin_body(world, pose, motion);
  add(world);
  finish_body(world, heaviness);
  return body_of(world, 0);
}

void expect_pose(const Pose<double>& a, const Pose<double>& b) { EXPECT_EQ(std::memcmp(&a, &b, sizeof a), 0); }

TEST(RigidMass, OfSimpleShapesIsThatOfClosedForms) {
  // Sums and products of a few terms of one sign: each value is good to about ten roundings.
  const double near = 1e-14;
  const Body box = made([](auto& world) { add_box(world, {.5, 1, 1.5}); }, of_mass(12));
  expect_near(box.inertia, {4 + 9, 1 + 9, 1 + 4}, 12 * near);
  EXPECT_NEAR(box.mass, 12, 12 * near);
  const Body sphere = made([](auto& world) { add_sphere(world, 2); }, of_density(3));
  EXPECT_NEAR(sphere.mass, 32 * M_PI, 100 * near);
  expect_near(sphere.inertia, {1.6 * 32 * M_PI, 1.6 * 32 * M_PI, 1.6 * 32 * M_PI}, 200 * near);

  // A capsule, cut across into thin discs. The error of Simpson's rule falls with the fourth power of the thickness,
  // even at the poles: the radius has an infinite slope there, but its square does not.
  const double half = .8, r = .5;
  const Body capsule = made([&](auto& world) { add_capsule(world, half, r); }, of_density(1));
  double mass = 0, along = 0, across = 0;
  const auto integrate = [&](double from, double to, auto radius_2) {
    constexpr int steps = 1000;
    for (int i = 0; i <= steps; ++i) {
      const double y = from + (to - from) * i / steps, weight = (i == 0 || i == steps ? 1
                                                                 : i % 2              ? 4
                                                                                      : 2) *
                                                                (to - from) / (3 * steps);
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
          for (int i = 0; i < 8; ++i)
            corners.push_back(offset + Vector{i % 2 ? .5 : -.5, i / 2 % 2 ? 1. : -1., i / 4 ? 1.5 : -1.5});
          add_hull(world, make_hull(world.hulls, corners));
        },
        of_mass(12), {{1, 2, 3}, no_rotation, 0});
    expect_near(hull.inertia, {13, 10, 5}, 1e-12);
    expect_near(hull.pose.position, Vector{1, 2, 3} + offset, 1e-14);
    EXPECT_EQ(hull.pose.orientation.w, 1);
  }
}

TEST(RigidMass, OfATetrahedronIsThatOfTheClosedForm) {
  // The tetrahedron is the corner of a cube of side 1 and has mass 1. The means of x^2 and x y are 1/10 and 1/20; about
  // the centre at 1/4 they are 3/80 and -1/80. The inertia has 6/80 on and 1/80 off its diagonal: 8/80 about the line
  // from the corner through the centre, 5/80 across it.
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

// The angular momentum of a body with a spin w: R I R^T w.
Vector angular_momentum(const Body& body, const Vector& spin) {
  const Matrix3<double> turn = matrix_of(body.pose.orientation);
  const Vector local = transposed_times(turn, spin);
  return turn * Vector{body.inertia.x * local.x, body.inertia.y * local.y, body.inertia.z * local.z};
}

TEST(RigidMass, OfACompoundIsThatOfItsParts) {
  // The body is an L of two boxes and a ball. It is turned and spins about its own origin.
  const Pose<double> poses[] = {
      {{0, 1, 0}, no_rotation, 0}, {{1, 0, .5}, {0, .6, 0, .8}, 0}, {{-1, -.5, 0}, no_rotation, 0}};
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
      expect_near(exact_place(all.pose, exact_place(local, p)), exact_place(somewhere, exact_place(poses[i], p)),
                  1e-14);
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
  const Body turned_cube = made(
      [](auto& world) {
        add_box(world, {1, 1, 1}, {{0, 0, 0}, {.6, 0, 0, .8}, 0});
      },
      of_mass(1));
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
    for (const std::size_t size : {bodies.pose.size(), bodies.motion.size(), bodies.inverse_mass.size(),
                                   bodies.friction.size(), bodies.restitution.size()})
      EXPECT_EQ(size, padded(n));
    for (const std::size_t size : {colliders.kind.size(), colliders.body.size(), colliders.group.size(),
                                   colliders.local.size(), colliders.hull.size(), colliders.size.size()})
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
    for (std::size_t i = hulls.count; i < padded(hulls.count + 1); ++i)
      EXPECT_EQ(hulls.first_vertex[i], hulls.first_vertex[hulls.count]);
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
  EXPECT_TRUE(a.bodies.count == b.bodies.count && a.colliders.count == b.colliders.count &&
              a.hulls.count == b.hulls.count);
  EXPECT_TRUE(same(a.bodies.pose, b.bodies.pose) && same(a.bodies.motion, b.bodies.motion));
  EXPECT_TRUE(same(a.bodies.inverse_mass, b.bodies.inverse_mass) && same(a.bodies.friction, b.bodies.friction));
  EXPECT_TRUE(same(a.bodies.restitution, b.bodies.restitution));
  EXPECT_TRUE(same(a.colliders.kind, b.colliders.kind) && same(a.colliders.local, b.colliders.local));
  EXPECT_TRUE(same(a.colliders.size, b.colliders.size) && same(a.colliders.hull, b.colliders.hull));
  EXPECT_TRUE(same(a.colliders.body, b.colliders.body) && same(a.colliders.group, b.colliders.group));
  EXPECT_TRUE(same(a.hulls.vertex, b.hulls.vertex) && same(a.hulls.plane, b.hulls.plane) &&
              same(a.hulls.corner, b.hulls.corner));
  EXPECT_TRUE(same(a.hulls.first_vertex, b.hulls.first_vertex) && same(a.hulls.first_face, b.hulls.first_face));
  EXPECT_TRUE(same(a.hulls.first_corner, b.hulls.first_corner) && same(a.hulls.centre, b.hulls.centre) &&
              same(a.hulls.half, b.hulls.half));
}

}  // namespace
}  // namespace lockstep::rigid::worlds
