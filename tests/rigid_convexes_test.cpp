// Convex against convex, against an exact oracle (tests/exact_convex.h), closed forms, itself turned round, and openmp against serial.
#include <gtest/gtest.h>
#include <omp.h>

#include <cmath>
#include <cstring>
#include <numbers>
#include <random>

#include "common/rigid/convexes.h"
#include "common/rigid/make.h"
#include "common/rigid/narrow_phase.h"
#include "tests/exact_convex.h"

namespace lockstep::rigid {
namespace {

using Vector = Vector3<double>;
constexpr double pi = std::numbers::pi;

// Shapes, one a collider, and pairs of them: colliders 2 k and 2 k + 1.
struct Cases {
  World<double> world = make_world();
  std::vector<Pose<double>> pose;

  Cases() { begin_body(world, no_offset); }
  void box(const Vector& half, const Pose<double>& at) { add_box(world, half), pose.push_back(at); }
  void hull(int which, const Pose<double>& at) { add_hull(world, which), pose.push_back(at); }
  void sphere(double radius, const Pose<double>& at) { add_sphere(world, radius), pose.push_back(at); }
  void capsule(double half, double radius, const Pose<double>& at) { add_capsule(world, half, radius), pose.push_back(at); }
  // Its corners as they are given, if the pose is at rest: the collider stands at their middle.
  void triangle(const Vector& p, const Vector& q, const Vector& r, const Pose<double>& at) {
    add_mesh(world, Mesh{{p, q, r}, {{0, 1, 2}}});
    const Pose<double>& local = world.colliders.local[world.colliders.count - 1];
    pose.push_back({at.position + matrix_of(at.orientation) * local.position, at.orientation, 0});
  }
};

// What a kernel made of them; pair k is collider 2 k against 2 k + 1, or turned round.
template <class Real>
struct Collided {
  World<Real> world;
  Array<Pose<Real>> pose;
  Pairs pairs;
  std::vector<Simplex> simplex;
  std::vector<SeparatingAxis<Real>> axis;
  std::vector<Manifold<Real>> manifold;

  Collided(const Cases& cases, bool turned_round = false) : world(convert<Real>(cases.world)) {
    for (const auto& [p, q, unused] : cases.pose)
      pose.push_back({{Real(p.x), Real(p.y), Real(p.z)}, {Real(q.x), Real(q.y), Real(q.z), Real(q.w)}, 0});
    for (int k = 0; k + 1 < static_cast<int>(pose.size()); k += 2) pairs.push_back(turned_round ? Pair{k + 1, k} : Pair{k, k + 1});
    simplex.resize(pairs.size());
    axis.resize(pairs.size());
    manifold.resize(pairs.size());
  }
  Placed<Real> placed() const { return {world.colliders, world.hulls, pose}; }
  void run(Gjk<Real>& gjk, ConvexAxes<Real>& convex_axes, ConvexClip<Real>& convex_clip, Real margin) {
    std::vector<Closest<Real>> closest(pairs.size());
    gjk(placed(), pairs, simplex, closest);
    convex_axes(placed(), pairs, simplex, closest, margin, axis);
    convex_clip(placed(), pairs, axis, margin, manifold);
  }
  void serial(Real margin) { run(serial::gjk, serial::convex_axes, serial::convex_clip, margin); }
  void openmp(Real margin) { run(openmp::gjk, openmp::convex_axes, openmp::convex_clip, margin); }
  ExactShape a(int k) const { return exact_collider(placed(), pairs[k].a); }
  ExactShape b(int k) const { return exact_collider(placed(), pairs[k].b); }
  double deepest(int k) const {
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < manifold[k].count; ++i) least = std::min<double>(least, manifold[k].point[i].separation);
    return least;
  }
};

double extent(const ExactShape& shape) {
  double most = 0;
  for (const Vector& p : shape.vertex)
    for (const Vector& q : shape.vertex) most = std::max(most, length(p - q));
  return most + 2 * shape.radius;
}

struct Random {
  std::mt19937 engine{1};
  double in(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine); }
  Vector direction() {
    for (;;) {
      const Vector v = {in(-1, 1), in(-1, 1), in(-1, 1)};
      if (const double l = length(v); l > .1 && l < 1) return 1 / l * v;
    }
  }
  Quaternion<double> rotation() {
    const Vector axis = direction();
    const double half = in(0, pi);
    return {std::sin(half) * axis.x, std::sin(half) * axis.y, std::sin(half) * axis.z, std::cos(half)};
  }
  Pose<double> pose(const Vector& position) { return {position, rotation(), 0}; }
};

int random_hull(Hulls<double>& hulls, Random& random, int points, const Vector& half) {
  std::vector<Vector> all;
  for (int k = 0; k < points; ++k) {
    const Vector d = random.direction();
    all.push_back({half.x * d.x, half.y * d.y, half.z * d.z});
  }
  return make_hull(hulls, all);
}

Vector vector(const Vector3<float>& v) { return {v.x, v.y, v.z}; }

const Pose<double> at_rest = no_offset;
Pose<double> at(const Vector& position) { return {position, no_rotation, 0}; }
Pose<double> turned(const Vector& position, const Vector& axis, double angle) {
  const double s = std::sin(angle / 2);
  return {position, {s * axis.x, s * axis.y, s * axis.z, std::cos(angle / 2)}, 0};
}

// How far a point is from the surface of a core with faces, if it is within rounding of it or inside.
double above_surface(const ExactShape& shape, const Vector& point) {
  double highest = -std::numeric_limits<double>::infinity();
  for (std::size_t f = 0; f < shape.face.size(); ++f)
    highest = std::max(highest, dot(shape.normal[f], point - shape.vertex[shape.face[f][0]]));
  return highest;
}

// Nothing but numbers, a unit normal, and points between the two surfaces.
void expect_sound(const Collided<float>& run, int k, float margin) {
  const Manifold<float>& m = run.manifold[k];
  ASSERT_GE(m.count, 0);
  ASSERT_LE(m.count, most_points);
  EXPECT_EQ(m.a, run.pairs[k].a);
  EXPECT_EQ(m.b, run.pairs[k].b);
  if (m.count == 0) return;
  EXPECT_NEAR(length(vector(m.normal)), 1, 1e-5) << k;
  const ExactShape a = run.a(k), b = run.b(k);
  for (int i = 0; i < m.count; ++i) {
    const auto& [position, separation] = m.point[i];
    EXPECT_TRUE(std::isfinite(position.x) && std::isfinite(position.y) && std::isfinite(position.z)) << k;
    EXPECT_LE(separation, margin) << k;
    const Vector half = .5 * separation * vector(m.normal);
    // Where cores are apart, where on a thin face the closest points are is known no better than rounding by the face's width, here some
    // hundredth of its length.
    const double rounding = (separation + a.radius + b.radius > 0 ? 1e-4 : 1e-5) * (extent(a) + extent(b));
    if (!a.face.empty() && a.radius == 0) {
      EXPECT_NEAR(above_surface(a, vector(position) - half), 0, rounding) << k << ' ' << i << ' ' << m.feature[i] % 256;
    }
    if (!b.face.empty() && b.radius == 0) {
      EXPECT_NEAR(above_surface(b, vector(position) + half), 0, rounding) << k << ' ' << i << ' ' << m.feature[i] % 256;
    }
    for (int j = 0; j < i; ++j) EXPECT_NE(m.feature[i], m.feature[j]) << k;
  }
}

std::vector<int> random_hulls(Hulls<double>& hulls, Random& random, int count, int least, int most) {
  std::vector<int> result;
  for (int k = 0; k < count; ++k)
    result.push_back(random_hull(hulls, random, least + k % (most - least + 1), {random.in(.3, 1), random.in(.3, 1), random.in(.3, 1)}));
  return result;
}

// Hulls and boxes at random places up to `far` from one another.
Cases random_cases(int count, double far, int seed) {
  Random random{std::mt19937(seed)};
  Cases cases;
  const std::vector<int> small = random_hulls(cases.world.hulls, random, 20, 5, 12),
                         large = random_hulls(cases.world.hulls, random, 4, 24, 24);
  const auto shape = [&](const Pose<double>& pose) {
    const unsigned k = random.engine() % 1000;
    if (k % 5 == 0)
      cases.box({random.in(.2, .8), random.in(.2, .8), random.in(.2, .8)}, pose);
    else
      cases.hull(k % 40 == 1 ? large[k / 40 % 4] : small[k % 20], pose);
  };
  for (int k = 0; k < count; ++k) {
    const Vector centre = {random.in(-5, 5), random.in(-5, 5), random.in(-5, 5)};
    shape(random.pose(centre));
    shape(random.pose(centre + random.in(0, far) * random.direction()));
  }
  return cases;
}

TEST(Convexes, DepthIsExact) {
  Collided<float> run(random_cases(40000, 1.6, 1));
  run.serial(0);
  double worst = 0;
  int overlapping = 0, shallow = 0;
  for (int k = 0; k < static_cast<int>(run.pairs.size()); ++k) {
    const ExactShape a = run.a(k), b = run.b(k);
    const ExactSeparation exact = separating_axis(a, b);
    const double size = std::max(extent(a), extent(b));
    expect_sound(run, k, 0);
    if (exact.separation > 1e-6 * size) {
      EXPECT_EQ(run.manifold[k].count, 0) << k;
    }
    if (exact.separation > -1e-6 * size) continue;
    ++overlapping;
    shallow += exact.separation > -.02 * size;
    ASSERT_GT(run.manifold[k].count, 0) << k << ' ' << exact.separation;
    const double error = std::abs(run.deepest(k) - exact.separation) / size;
    worst = std::max(worst, error);
    EXPECT_LT(error, 1e-5) << k << " exact " << exact.separation << " got " << run.deepest(k);
    // The normal separates as far as the depth says.
    EXPECT_NEAR(separation_along(a, b, vector(run.manifold[k].normal)), exact.separation, 1e-5 * size) << k;
  }
  EXPECT_GE(overlapping, 20000);
  EXPECT_GE(shallow, 1000);
  RecordProperty("worst", std::to_string(worst));
}

TEST(Convexes, TurnedRoundIsMirrored) {
  const Cases cases = random_cases(4000, 2, 2);
  Collided<float> run(cases), round(cases, true);
  const float margin = .05f;
  run.serial(margin), round.serial(margin);
  for (int k = 0; k < static_cast<int>(run.pairs.size()); ++k) {
    const ExactShape a = run.a(k), b = run.b(k);
    const double rounding = 1e-5 * std::max(extent(a), extent(b));
    if (run.manifold[k].count != 0 && round.manifold[k].count != 0) {
      EXPECT_NEAR(run.deepest(k), round.deepest(k), rounding) << k;
      // Of equally deep axes either may be taken.
      const Vector normal = -vector(round.manifold[k].normal);
      if (run.deepest(k) < 0) {
        EXPECT_NEAR(separation_along(a, b, normal), run.deepest(k), rounding) << k;
      }
    } else if (run.manifold[k].count != round.manifold[k].count) {
      EXPECT_NEAR(run.manifold[k].count != 0 ? run.deepest(k) : round.deepest(k), margin, rounding) << k;
    }
  }
}

// Points where the distance is not more than the margin, and only there; the deepest has the distance.
TEST(Convexes, PointsExactlyWithinMargin) {
  Random random;
  Cases cases;
  const std::vector<int> hulls = random_hulls(cases.world.hulls, random, 8, 5, 12);
  for (int k = 0; k < 10000; ++k) {
    const Vector centre = {random.in(-5, 5), random.in(-5, 5), random.in(-5, 5)};
    cases.hull(hulls[k % 8], random.pose(centre));
    const Pose<double> other = random.pose(centre + random.in(.4, 1.6) * random.direction());
    if (k % 4 == 0) cases.sphere(random.in(.05, .4), other);
    if (k % 4 == 1) cases.capsule(random.in(.05, .4), random.in(.05, .4), other);
    if (k % 4 == 2) cases.hull(hulls[k / 8 % 8], other);
    if (k % 4 == 3) cases.triangle(random.direction(), random.direction(), random.direction(), other);
  }
  const float margin = .02f;
  Collided<float> run(cases);
  run.serial(margin);
  int within = 0;
  for (int k = 0; k < static_cast<int>(run.pairs.size()); ++k) {
    const ExactShape a = run.a(k), b = run.b(k);
    const ExactSeparation exact = exact_separation(a, b);
    const double rounding = 1e-5 * std::max(extent(a), extent(b));
    expect_sound(run, k, margin);
    if (exact.separation > margin + rounding) {
      EXPECT_EQ(run.manifold[k].count, 0) << k << ' ' << exact.separation;
    }
    if (exact.separation > margin - rounding) continue;
    ++within;
    ASSERT_GT(run.manifold[k].count, 0) << k << ' ' << exact.separation;
    EXPECT_NEAR(run.deepest(k), exact.separation, rounding) << k;
    if (exact.separation + a.radius + b.radius > .001) {  // where cores are well apart there is one normal
      EXPECT_LT(length(exact.normal - vector(run.manifold[k].normal)), 5e-3) << k << ' ' << exact.separation;
    }
  }
  EXPECT_GT(within, 2000);
}

TEST(Convexes, SphereAndCapsuleInClosedForm) {
  Cases cases;
  const Pose<double> cube = at({1, 2, 3});
  const auto against = [&](const Vector& offset) {
    cases.box({1, 1, 1}, cube);
    cases.sphere(.5, at(cube.position + offset));
  };
  against({0, 1.25, .5});      // above a face, .25 deep
  against({1.24, 1.32, 0});    // at an edge: the core is .4 from it
  against({1.2, 1.2, 1.1});    // at a corner: .3
  against({.2, .9, 0});        // centre inside, .1 below a face: .6 deep
  cases.box({1, 1, 1}, cube);  // lying on a face, its ends within it, .1 deep
  cases.capsule(.5, .5, turned(cube.position + Vector{0, 1.4, 0}, {0, 0, 1}, pi / 2));
  cases.box({1, 1, 1}, cube);  // lying across it: clipped at the edges
  cases.capsule(3, .5, turned(cube.position + Vector{0, 1.4, .25}, {0, 0, 1}, pi / 2));
  cases.box({1, 1, 1}, cube);  // upright
  cases.capsule(.5, .5, at(cube.position + Vector{.5, 1.9, .25}));
  cases.triangle({-1, 0, -1}, {0, 0, 2}, {1, 0, -1}, cube);  // a sphere over a triangle
  cases.sphere(.5, at(cube.position + Vector{0, .4, 0}));
  cases.capsule(.5, .25, at(cube.position + Vector{0, -.6, 0}));  // a capsule below it, and first
  cases.triangle({-1, 0, -1}, {0, 0, 2}, {1, 0, -1}, cube);
  Collided<float> run(cases);
  run.serial(0);

  const auto expect = [&](int k, const Vector& normal, int count, double deepest) {
    const Manifold<float>& m = run.manifold[k];
    EXPECT_EQ(m.count, count) << k;
    EXPECT_NEAR(run.deepest(k), deepest, 2e-6) << k;
    EXPECT_LT(length(vector(m.normal) - normal), 2e-6) << k;
  };
  expect(0, {0, 1, 0}, 1, -.25);
  EXPECT_LT(length(vector(run.manifold[0].point[0].position) - (cube.position + Vector{0, .875, .5})), 2e-6);
  expect(1, {.6, .8, 0}, 1, -.1);
  expect(2, {2. / 3, 2. / 3, 1. / 3}, 1, -.2);
  expect(3, {0, 1, 0}, 1, -.6);
  expect(4, {0, 1, 0}, 2, -.1);
  EXPECT_NEAR(std::abs(run.manifold[4].point[0].position.x - run.manifold[4].point[1].position.x), 1, 2e-6);
  expect(5, {0, 1, 0}, 2, -.1);
  EXPECT_NEAR(std::abs(run.manifold[5].point[0].position.x - run.manifold[5].point[1].position.x), 2, 1e-5);
  EXPECT_NEAR(run.manifold[5].point[0].position.z, 3.25, 2e-6);
  expect(6, {0, 1, 0}, 1, -.1);
  expect(7, {0, 1, 0}, 1, -.1);
  expect(8, {0, 1, 0}, 1, -.15);
}

// Cubes on one another: at any turn about the vertical, four points at the corners of what they share, or of a square's and a turned
// square's octagon four wide apart.
TEST(Convexes, StackedCubes) {
  Cases cases;
  const double depths[] = {0, 1e-6, .001, -.001};
  for (const double depth : depths)
    for (const double angle : {0., .3, pi / 4}) {
      cases.box({.5, .5, .5}, at({3, .5, -2}));
      cases.box({.5, .5, .5}, turned({3, 1.5 - depth, -2}, {0, 1, 0}, angle));
    }
  Collided<float> run(cases);
  run.serial(.01f);
  for (int k = 0; k < static_cast<int>(run.pairs.size()); ++k) {
    const Manifold<float>& m = run.manifold[k];
    ASSERT_EQ(m.count, 4) << k;
    EXPECT_LT(length(vector(m.normal) - Vector{0, 1, 0}), 1e-6) << k;
    double low_x = 1, high_x = -1, low_z = 1, high_z = -1;
    for (const auto& [position, separation] : m.point) {
      EXPECT_NEAR(separation, -depths[k / 3], 1e-6) << k;
      EXPECT_NEAR(position.y, 1 - depths[k / 3] / 2, 1e-6) << k;
      low_x = std::min<double>(low_x, position.x - 3), high_x = std::max<double>(high_x, position.x - 3);
      low_z = std::min<double>(low_z, position.z + 2), high_z = std::max<double>(high_z, position.z + 2);
    }
    const double wide = k % 3 == 0 ? .5 - 1e-5 : .4;
    EXPECT_LE(low_x, -wide) << k;
    EXPECT_GE(high_x, wide) << k;
    EXPECT_LE(low_z, -wide) << k;
    EXPECT_GE(high_z, wide) << k;
  }
}

// A hexagonal prism flat on a table, one hanging half over its edge, and one that stands on an edge.
TEST(Convexes, RestingHulls) {
  Cases cases;
  std::vector<Vector> prism;
  for (int k = 0; k < 6; ++k)
    for (const double y : {-.1, .1}) prism.push_back({.3 * std::cos(k * pi / 3), y, .3 * std::sin(k * pi / 3)});
  const int hull = make_hull(cases.world.hulls, prism);
  const auto on_table = [&](const Pose<double>& pose) {
    cases.box({1, .5, 1}, at_rest);
    cases.hull(hull, pose);
  };
  on_table(at({.2, .599, 0}));
  on_table(at({1, .599, 0}));
  on_table(turned({0, .5 + .3 * std::sqrt(3) / 2 - .001, 0}, {1, 0, 0}, pi / 2));  // on a side: its four corners
  on_table(turned({0, .5 + .3 - .001, 0}, {std::sqrt(.5), 0, std::sqrt(.5)}, 0));
  Collided<float> run(cases);
  run.serial(.005f);
  for (const int k : {0, 1, 2}) {
    const Manifold<float>& m = run.manifold[k];
    EXPECT_EQ(m.count, 4) << k;
    EXPECT_LT(length(vector(m.normal) - Vector{0, 1, 0}), 1e-6) << k;
    for (int i = 0; i < m.count; ++i) EXPECT_NEAR(m.point[i].separation, -.001, 2e-6) << k;
  }
  for (const auto& [position, separation] : run.manifold[1].point) EXPECT_LT(position.x, 1 + 1e-5);
}

// Whatever touches or coincides in a corner, an edge or a face, however flat: numbers, and a depth that is right.
TEST(Convexes, Degenerate) {
  Random random;
  Cases cases;
  const int needle = make_hull(cases.world.hulls, std::vector<Vector>{{-5, 0, 0}, {5, .01, 0}, {5, -.01, .01}, {5, -.01, -.01}});
  const int plate = make_hull(
      cases.world.hulls,
      std::vector<Vector>{{1, 0, 1}, {-1, 0, 1}, {-1, 0, -1}, {1, 0, -1}, {1, .001, 1}, {-1, .001, 1}, {-1, .001, -1}, {1, .001, -1}});
  const int tetrahedron = make_hull(cases.world.hulls, std::vector<Vector>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  const auto cube = [&](const Vector& p) { cases.box({1, 1, 1}, at(p)); };
  const Vector touching[] = {{2, 2, 2}, {2, 2, 0}, {2, 0, 0}, {2, 2, .5}, {2, .5, .5}, {0, 0, 0}, {1, 1, 1}, {0, 0, 1}};
  for (const Vector& p : touching) cube({0, 0, 0}), cube(p);
  for (const int hull : {needle, plate, tetrahedron}) {
    for (int k = 0; k < 200; ++k) {
      cases.hull(hull, random.pose({0, 0, 0})), cases.hull(hull, random.pose(random.in(0, .2) * random.direction()));
      const Pose<double> pose = random.pose({1, 2, 3});
      cases.hull(hull, pose), cases.hull(hull, pose);  // coincident
      cube({0, 0, 0}), cases.hull(hull, random.pose(random.in(0, 2) * random.direction()));
    }
    cases.hull(hull, at_rest), cases.hull(hull, turned({0, 0, 0}, {0, 1, 0}, .5));
  }
  cases.hull(tetrahedron, at_rest), cases.hull(tetrahedron, turned({0, 0, 0}, {0, 0, 1}, pi));       // corner, edge
  cases.hull(tetrahedron, at_rest), cases.hull(tetrahedron, turned({0, 0, 0}, {0, 1, 0}, -pi / 2));  // face on face
  const Vector p = {0, 0, 0}, q = {1, 0, 0}, r = {0, 0, 1};
  const auto triangle = [&](const Pose<double>& pose) { cases.triangle(p, q, r, pose); };
  triangle(at_rest), triangle(at_rest);                            // coincident
  triangle(at_rest), triangle(at({.2, 0, .2}));                    // in one plane
  triangle(at_rest), triangle(turned({.2, 0, .2}, {1, 0, 0}, 1));  // through one another
  triangle(at_rest), triangle(turned({.3, -.2, .3}, {1, 0, 0}, pi / 2));
  triangle(at_rest), cube({0, 0, 0});
  triangle(at_rest), cube({.2, 1, .2});  // a cube on it
  triangle(at_rest), cube({1.5, .5, .1});
  triangle(at_rest), cases.sphere(.25, at({.25, 0, .25}));                             // a centre on it
  triangle(at_rest), cases.sphere(.25, at({0, 0, 0}));                                 // and on its corner
  triangle(at_rest), cases.capsule(.5, .1, at({.25, 0, .25}));                         // through it
  triangle(at_rest), cases.capsule(.5, .1, turned({.25, 0, .25}, {0, 0, 1}, pi / 2));  // in its plane
  cube({0, 0, 0}), cases.sphere(.25, at({1, 1, 1}));
  cube({0, 0, 0}), cases.capsule(.5, .1, at({1, 0, 1}));  // along an edge
  cube({0, 0, 0}), cases.capsule(1, .1, at({0, 0, 0}));
  for (const bool turned_round : {false, true}) {
    Collided<float> run(cases, turned_round);
    run.serial(.001f);
    for (int k = 0; k < static_cast<int>(run.pairs.size()); ++k) {
      expect_sound(run, k, .001f);
      const ExactShape a = run.a(k), b = run.b(k);
      const ExactSeparation exact = exact_separation(a, b);
      if (exact.separation > .001) continue;
      ASSERT_GT(run.manifold[k].count, 0) << k << ' ' << exact.separation;
      EXPECT_NEAR(run.deepest(k), exact.separation, 1e-5 * std::max(extent(a), extent(b))) << k;
    }
    // From where GJK ended it comes to the same.
    const std::vector<Manifold<float>> cold = run.manifold;
    run.serial(.001f);
    for (int k = 0; k < static_cast<int>(run.pairs.size()); ++k) {
      EXPECT_EQ(run.manifold[k].count != 0, cold[k].count != 0) << k;
    }
  }
}

// Every shape against every other, near, touching, deep and far.
Cases mixed_cases(int count) {
  Random random{std::mt19937(3)};
  Cases cases;
  std::vector<int> hulls = random_hulls(cases.world.hulls, random, 12, 4, 26);
  std::vector<Vector> ball, drum;  // as many vertices, and faces with as many corners, as there may be
  for (int k = 0; k < 64; ++k) {
    ball.push_back(random.direction());
    const double angle = k / 2 * pi / 16;
    drum.push_back({.5 * std::cos(angle), k % 2 ? .2 : -.2, .5 * std::sin(angle)});
  }
  hulls.push_back(make_hull(cases.world.hulls, ball));
  hulls.push_back(make_hull(cases.world.hulls, drum));
  const auto shape = [&](int kind, const Pose<double>& pose) {
    if (kind < 6) cases.hull(hulls[random.engine() % hulls.size()], pose);
    if (kind == 6) cases.box({random.in(.2, .8), random.in(.2, .8), random.in(.2, .8)}, pose);
    if (kind == 7) cases.triangle(random.direction(), random.direction(), random.direction(), pose);
    if (kind == 8) cases.sphere(random.in(.05, .4), pose);
    if (kind == 9) cases.capsule(random.in(.05, .4), random.in(.05, .4), pose);
  };
  for (int k = 0; k < count; ++k) {
    const Vector centre = {random.in(-5, 5), random.in(-5, 5), random.in(-5, 5)};
    const bool aligned = random.engine() % 4 == 0;
    const auto pose = [&](const Vector& position) { return aligned ? at(position) : random.pose(position); };
    const int kind = random.engine() % 10, other = random.engine() % 8;  // one of the two has faces
    const Vector there = centre + (aligned ? Vector{0, random.in(.5, 1.1), 0} : random.in(0, 1.8) * random.direction());
    const bool swap = random.engine() % 2 == 0;
    shape(swap ? other : kind, pose(centre));
    shape(swap ? kind : other, pose(there));
  }
  return cases;
}

TEST(Convexes, LanesHaveTheBitsOfTheSerialCode) {
  for (const int count : {0, 1, 15, 16, 17, 6000}) {
    const Cases cases = mixed_cases(count);
    Collided<float> cold(cases), warm(cases);  // from nothing, and from where GJK ended
    cold.serial(.02f);
    warm.simplex = cold.simplex;
    warm.serial(.02f);
    for (const int threads : {1, 2, 3, 8}) {
      omp_set_num_threads(threads);
      Collided<float> openmp(cases);
      for (const Collided<float>* serial : {&cold, &warm}) {
        openmp.openmp(.02f);
        for (int k = 0; k < count; ++k) {
          ASSERT_EQ(std::memcmp(&openmp.simplex[k], &serial->simplex[k], sizeof(Simplex)), 0) << k;
          ASSERT_EQ(std::memcmp(&openmp.manifold[k], &serial->manifold[k], sizeof(Manifold<float>)), 0) << k << " of " << count;
        }
      }
    }
  }
}

// A pose of NaN, of a pair that is said to be near: the axis is NaN, and that is all.
TEST(Convexes, NaNEnds) {
  Random random;
  Cases cases;
  const int hull = random_hull(cases.world.hulls, random, 40, {1, 1, 1});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  cases.hull(hull, at({nan, nan, nan})), cases.hull(hull, at_rest);
  cases.hull(hull, {{0, 0, 0}, {nan, 0, 0, 1}, 0}), cases.hull(hull, at_rest);
  Collided<float> run(cases);
  const std::vector<Closest<float>> near(run.pairs.size(), {{0, 0, 0}, {0, 0, 0}, 0, 1});
  for (ConvexAxes<float>* convex_axes : {serial::convex_axes, openmp::convex_axes}) {
    (*convex_axes)(run.placed(), run.pairs, run.simplex, near, .01f, run.axis);
    for (const SeparatingAxis<float>& axis : run.axis) EXPECT_FALSE(axis.separation >= 0) << axis.separation;
  }
}

}  // namespace
}  // namespace lockstep::rigid
