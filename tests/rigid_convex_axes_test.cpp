// Separating axes of convex shapes: depth against an exact oracle (tests/exact_convex.h), pairs in either order,
// degenerate pairs, NaN.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "tests/rigid_convexes.h"

namespace lockstep::rigid::convex_pairs {
namespace {

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
    // The shapes overlap along the normal by the depth.
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
      // Either of two equally deep axes is right.
      const Vector normal = -vector(round.manifold[k].normal);
      if (run.deepest(k) < 0) {
        EXPECT_NEAR(separation_along(a, b, normal), run.deepest(k), rounding) << k;
      }
    } else if (run.manifold[k].count != round.manifold[k].count) {
      EXPECT_NEAR(run.manifold[k].count != 0 ? run.deepest(k) : round.deepest(k), margin, rounding) << k;
    }
  }
}

// Shapes touch or coincide in a corner, an edge or a face, however flat. All numbers are finite, and the depth is
// right.
TEST(Convexes, Degenerate) {
  Random random;
  Cases cases;
  const int needle =
      make_hull(cases.world.hulls, std::vector<Vector>{{-5, 0, 0}, {5, .01, 0}, {5, -.01, .01}, {5, -.01, -.01}});
  const int plate = make_hull(
      cases.world.hulls,
      std::vector<Vector>{
          {1, 0, 1}, {-1, 0, 1}, {-1, 0, -1}, {1, 0, -1}, {1, .001, 1}, {-1, .001, 1}, {-1, .001, -1}, {1, .001, -1}});
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
    // A warm start gives the same answer.
    const std::vector<Manifold<float>> cold = run.manifold;
    run.serial(.001f);
    for (int k = 0; k < static_cast<int>(run.pairs.size()); ++k) {
      EXPECT_EQ(run.manifold[k].count != 0, cold[k].count != 0) << k;
    }
  }
}

// A pose is NaN, and its pair counts as near: the axis is NaN, and the kernel ends.
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
}  // namespace lockstep::rigid::convex_pairs
