// Contact points of convex shapes: against an exact oracle (tests/exact_convex.h), closed forms, and openmp against
// serial.
#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "tests/rigid_convexes.h"

namespace lockstep::rigid::convex_pairs {
namespace {

// A pair has points if and only if its distance is at most the margin. The deepest point has this distance.
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
    if (exact.separation + a.radius + b.radius > .001) {  // cores that are well apart have one normal
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

// A cube stands on another, turned about the vertical by some angle. The manifold has four points: the corners of the
// common square, or four points far apart of the octagon that the square and a turned square share.
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

// A hexagonal prism lies flat on a table, hangs half over its edge, lies on a side, or stands on an edge.
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

// Every shape against every other: near, touching, deep and far.
Cases mixed_cases(int count) {
  Random random{std::mt19937(3)};
  Cases cases;
  std::vector<int> hulls = random_hulls(cases.world.hulls, random, 12, 4, 26);
  std::vector<Vector> ball, drum;  // the most vertices that a hull may have, and faces with the most corners
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
    Collided<float> cold(cases), warm(cases);  // a cold start, and a start from the simplex at which GJK ended
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
          ASSERT_EQ(std::memcmp(&openmp.manifold[k], &serial->manifold[k], sizeof(Manifold<float>)), 0)
              << k << " of " << count;
        }
      }
    }
  }
}

}  // namespace
}  // namespace lockstep::rigid::convex_pairs
