// Solid bodies of the production cloth: level sets of meshes against shapes with a formula; and cloths on slopes, which
// stick or slide as Coulomb has it.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "common/input_error.h"
#include "common/production_cloth/collide_bodies.h"
#include "tests/production_cloth_contacts.h"
#include "tests/temporary_folder.h"
#include "verify/production_cloth/moving.h"

namespace lockstep::production_cloth {
namespace {

constexpr double u = 0x1p-24;

// --- Level sets

// A box of half sides about the origin.
Mesh box_mesh(const Vector3<double>& half) {
  Mesh mesh;
  for (int k = 0; k < 8; ++k)
    mesh.points.push_back({k & 1 ? half.x : -half.x, k & 2 ? half.y : -half.y, k & 4 ? half.z : -half.z});
  for (const auto& [a, b, c, d] :
       {std::array{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}})
    mesh.triangles.push_back({a, b, c}), mesh.triangles.push_back({a, c, d});
  return mesh;
}

struct LevelSetOfBox {
  Vector3<double> half = {.5, .25, .375};
  double spacing = 1 / 32.;
  LevelSet<double> shape = make_level_set(box_mesh(half), spacing, "box");
  Path path = {.pivot = {.1, .2, .3}, .keys = {{0, {{.3, -.5, .7}, {.1, .2, -.3}}}, {1, {{.4, 0, .2}, {0, .1, 0}}}}};

  template <class Shape>
  MovedBodies<float> moved(const Shape& of, double thickness) const {
    return move_bodies({Body{.shape = of, .friction = .5, .path = path}}, .25, .5, thickness);
  }
};

// Where one face is the nearest of all points of the grid around a point, the distance is linear there, and so the way
// out is that of the box. Coordinates are below 1. Of the way to the face: the origin's and three directions' rounding
// (4), the difference (1), the product with each direction and two sums (5), the spacing's and its inverse's (3): 13 u.
// Values up to 6 spacings are rounded, and in three interpolations three times each: 10 u. The slope, of differences of
// such values over a spacing, is off by twice 6 u each, and more by 3 interpolations: 40 u; so is its length, and its
// direction once more. The box's own formula takes 12 u.
TEST(ProductionClothLevelSets, PushAlongTheWayOutOfABox) {
  const LevelSetOfBox level_set;
  const double thickness = .01;
  const cloth::Box<double> box = {{0, 0, 0}, level_set.half, {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}};
  const MovedBodies<float> of_mesh = level_set.moved(level_set.shape, thickness);
  const MovedBodies<float> of_box = level_set.moved(box, thickness);
  const Placement placement = placement_at(level_set.path, .5);
  std::mt19937 random(1);
  const auto share = [&] { return 2 * static_cast<double>(random() >> 8) / (1 << 24) - 1; };
  int compared = 0;
  for (int k = 0; k < 20'000; ++k) {
    const double x = share(), y = share(), z = share();
    const Vector3<double> p = {.6 * x, .3 * y, .45 * z};
    const Vector3<double> depth = {level_set.half.x - std::abs(p.x), level_set.half.y - std::abs(p.y),
                                   level_set.half.z - std::abs(p.z)};
    std::array<double, 3> order = {depth.x, depth.y, depth.z};
    std::ranges::sort(order);
    // Two spacings apart, and no corner of the cell is beside an edge or out of reach.
    const double margin = 3 * level_set.spacing;
    if (order[1] - order[0] < margin || order[1] < margin || std::abs(order[0]) > 5 * level_set.spacing) continue;
    const Vector3<float> at = convert<float>(placed(level_set.path, placement, p));
    const auto found = way_out(of_mesh.level_sets[0].shape, at);
    const auto expected = cloth::way_out(of_box.boxes[0].shape, at);
    EXPECT_NEAR(found.depth, expected.depth, 35 * u);
    EXPECT_NEAR(found.normal.x, expected.normal.x, 120 * u);
    EXPECT_NEAR(found.normal.y, expected.normal.y, 120 * u);
    EXPECT_NEAR(found.normal.z, expected.normal.z, 120 * u);
    ++compared;
  }
  EXPECT_GT(compared, 1000);
}

// A level set and the box that it is of have the same motion: d(x) is the path's.
TEST(ProductionClothLevelSets, MoveAsOtherBodiesDo) {
  const LevelSetOfBox level_set;
  const cloth::Box<double> box = {{0, 0, 0}, level_set.half, {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}};
  const MovedBodies<float> of_mesh = level_set.moved(level_set.shape, 0), of_box = level_set.moved(box, 0);
  const Vector3<float> x = {.3f, -.2f, .9f};
  EXPECT_EQ(displacement_of(of_mesh.level_sets[0], x).x, displacement_of(of_box.boxes[0], x).x);
  EXPECT_EQ(displacement_of(of_mesh.level_sets[0], x).y, displacement_of(of_box.boxes[0], x).y);
  EXPECT_EQ(displacement_of(of_mesh.level_sets[0], x).z, displacement_of(of_box.boxes[0], x).z);
}

// What is beyond the grid is outside, whatever the room; what is deeper than the reach finds no way out.
TEST(ProductionClothLevelSets, LeaveWhatIsFarOrTooDeep) {
  const Vector3<double> half = {.5, .5, .5};
  const MovedBodies<float> moved = move_bodies(
      {Body{.shape = make_level_set(box_mesh(half), 1 / 64., "box"), .friction = 0, .path = {}}}, 0, 1, .04);
  for (const float x : {-1e9f, -3.f, -.6f, .6f, 3.f, 1e9f})
    for (const Vector3<float>& p : {Vector3<float>{x, 0, 0}, {0, x, 0}, {0, 0, x}, {x, x, x}})
      EXPECT_LT(way_out(moved.level_sets[0].shape, p).depth, 0) << x;
  EXPECT_LT(way_out(moved.level_sets[0].shape, Vector3<float>{0, 0, 0}).depth, 0);
  EXPECT_NEAR(way_out(moved.level_sets[0].shape, Vector3<float>{.4f, 0, 0}).depth, .14, 35 * u);
}

TEST(ProductionClothLevelSets, HaveTheSerialBits) {
  const LevelSetOfBox level_set;
  const MovedBodies<float> bodies = level_set.moved(level_set.shape, .01);
  const Placement placement = placement_at(level_set.path, .5);
  for (const int vertices : {0, 1, 15, 16, 17, 2000}) {
    std::mt19937 random(3);
    const auto share = [&] { return 2 * static_cast<double>(random() >> 8) / (1 << 24) - 1; };
    Array<float> inverse_mass(padded(vertices));
    Vectors<float> start;
    Motion<float> motion;
    start.resize(vertices), motion.position.resize(vertices), motion.velocity.resize(vertices);
    for (int i = 0; i < vertices; ++i) {
      const double x = share(), y = share(), z = share();
      inverse_mass[i] = i % 7 ? 1.f : 0.f;
      store(start, i, convert<float>(placed(level_set.path, placement, {.8 * x, .5 * y, .6 * z})));
      store(motion.position, i, load(start, i) + Vector3<float>{.01f, -.02f, .005f});
      store(motion.velocity, i, {0, 0, 7});
    }
    const auto pushed = [&](CollideBodies<float>* collide) {
      Motion<float> m = motion;
      collide(bodies, vertices, .1f, inverse_mass, start, m.position, m.velocity);
      return m;
    };
    CollideBodies<float>* const serial_form = serial::collide_bodies;
    const Motion<float> expected = pushed(serial_form);
    int moved = 0;
    for (int i = 0; i < vertices; ++i) moved += load(expected.velocity, i).z != 7;
    EXPECT_TRUE(vertices < 100 || moved > 100);
    at_each_team([&] {
      const Motion<float> found = pushed(openmp::collide_bodies);
      EXPECT_TRUE(same_vectors(found.position, expected.position, vertices));
      EXPECT_TRUE(same_vectors(found.velocity, expected.velocity, vertices));
    });
  }
}

// --- Slopes

struct ProductionClothSlope : TemporaryFolder {
  static constexpr double gravity = 9.75, tangent = .5, thickness = 1 / 512.;
  static constexpr double sine = .44721359549995793, cosine = .89442719099991586;
  static constexpr int steps = 32;
  static constexpr double time_step = 1 / 64.;
  // A square of 20 cm, along the slope.
  const std::string sheet =
      "frame_time = 0.015625\nsubsteps = 1\ngravity = [0, -9.75, 0]\n"
      "[[sheet]]\norigin = [-0.3577708764, 0.1788854382, -0.1]\nacross = [0.1788854382, -0.0894427191, 0]\n"
      "down = [0, 0, 0.2]\nsquares = [2, 2]\n"
      "[material]\nstiffness = 0.1\nstretch_damping = 0\nbend = \"none\"\n[contact]\nthickness = 0.001953125\n";

  // How far the sheet's vertices are down the slope after each step: the least and the greatest.
  struct Slid {
    double least, greatest;
  };
  std::vector<Slid> slide(const std::string& slope) {
    write_bytes(path("a.toml"), "kind = \"production_cloth\"\n" + sheet + slope);
    const Scene scene = load_scene(path("a.toml"));
    const Cloth<float> cloth = verify::make_cloth(scene);
    Motion<float> motion = verify::motion_at_rest(scene);
    StepMemory<float> memory = openmp::make_memory(cloth);
    std::vector<Slid> slid;
    for (int k = 0; k < steps; ++k) {
      openmp::step_batches(cloth, script_of(scene, k * time_step, (k + 1) * time_step), motion, memory);
      Slid now = {1e9, -1e9};
      for (int v = 0; v < scene.topology.vertices; ++v) {
        const Vector3<double> way = convert<double>(load(motion.position, v)) - load(scene.rest, v);
        const double down = cosine * way.x - sine * way.y;
        now = {std::min(now.least, down), std::max(now.greatest, down)};
      }
      slid.push_back(now);
    }
    return slid;
  }

  // A step moves the middle velocity by dt a, a = g (sine - friction cosine), the first one by half of that: the sheet
  // is where it should be, a t^2 / 2, at the end of each step. Coordinates are below half a metre. A step rounds them
  // at most 48 times: the move and the push four times, the depth eighteen times (LevelSets above), which the next step
  // finds again in its own depth; and friction gives a share of the depths on. What is rounded in a step is part of the
  // velocity, too: it comes again each step. Springs are off by 16 u of their stiffness, as in free fall.
  static double bound(double t) {
    const double lightest = .2 * .1 * .1 / 2 / 3, n = t / time_step;
    return .5 * n * (n + 1) * 48 * u * .5 + .5 * t * t * 16 * u * .1 / lightest;
  }

  void slides_with(double friction, const std::string& slope) {
    const double acceleration = gravity * (sine - friction * cosine);
    const std::vector<Slid> slid = slide(slope + "friction = " + std::to_string(friction) + "\n");
    for (int k = 0; k < steps; ++k) {
      const double t = (k + 1) * time_step, expected = friction < tangent ? .5 * acceleration * t * t : 0;
      EXPECT_NEAR(slid[k].least, expected, bound(t)) << friction << " after " << k + 1 << " steps";
      EXPECT_NEAR(slid[k].greatest, expected, bound(t)) << friction << " after " << k + 1 << " steps";
    }
    if (friction > tangent) {  // what sticks does not gather speed: the bound is that of its rounding, step by step
      EXPECT_LE(std::max(-slid.back().least, slid.back().greatest), steps * 48 * u * .5);
    } else {
      EXPECT_GT(slid.back().least, 10 * bound(.5));
    }
  }
};

TEST_F(ProductionClothSlope, SticksOrSlidesOnAPlane) {
  for (const double friction : {0., .2, .4, .49, .51, .8})
    slides_with(friction,
                "[[plane]]\nnormal = [0.5, 1, 0]\npoint = [-0.0008734640537108554, -0.0017469281074217108, 0]\n");
}

// The same slope as the face of a mesh that is turned.
TEST_F(ProductionClothSlope, SticksOrSlidesOnALevelSet) {
  std::string obj;
  const Mesh mesh = box_mesh({.75, .25, .375});
  for (const auto& [x, y, z] : mesh.points)
    obj += "v " + std::to_string(x) + ' ' + std::to_string(y - .25 - thickness) + ' ' + std::to_string(z) + '\n';
  for (const auto& [a, b, c] : mesh.triangles)
    obj += "f " + std::to_string(a + 1) + ' ' + std::to_string(b + 1) + ' ' + std::to_string(c + 1) + '\n';
  write_bytes(path("box.obj"), obj);
  for (const double friction : {0., .4, .49, .51})
    slides_with(friction,
                "[[solid]]\nfile = \"box.obj\"\nspacing = 0.03125\n"
                "key = [{ time = 0, turn = [0, 0, -0.46364760900080609] }]\n");
}

// --- What is refused

TEST_F(ProductionClothSlope, RefusesSolidsWithoutAnInside) {
  write_bytes(path("open.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const auto says = [&](const std::string& text, const std::string& part) {
    try {
      slide(text);
      ADD_FAILURE() << text;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
  };
  says("[[solid]]\nfile = \"open.obj\"\nspacing = 0.1\n", "expected two: a closed mesh");
  says("[[solid]]\nfile = \"open.obj\"\nspacing = 0.0001\n", "a third of the contact's thickness");
  says("[[solid]]\nfile = \"open.obj\"\n", "spacing");
}

TEST(ProductionClothLevelSets, RefuseGridsOfTooManyPoints) {
  EXPECT_THROW(make_level_set(box_mesh({1, 1, 1}), 1e-4, "box"), InputError);
}

}  // namespace
}  // namespace lockstep::production_cloth
