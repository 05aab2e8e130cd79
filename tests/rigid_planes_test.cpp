// Planes against spheres, capsules, boxes and hulls: every corner's height, which corners are chosen and why, and both
// versions against each other.
#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <random>
#include <set>

#include "common/rigid/narrow_phase.h"
#include "tests/exact_convex.h"
#include "tests/rigid_shapes.h"

namespace lockstep::rigid {
namespace {

template <class Real>
std::vector<Manifold<Real>> collide(const Shapes& shapes, const Pairs& pairs, double margin) {
  const Rounded<Real> rounded(shapes);
  std::vector<Manifold<Real>> manifolds(pairs.size());
  serial::planes(rounded.placed(), pairs, static_cast<Real>(margin), manifolds);
  return manifolds;
}

template <class Real>
Vector3<double> in_double(const Vector3<Real>& v) {
  return {v.x, v.y, v.z};
}

// A hull of points on a sphere.
int ball(Shapes& shapes, int points, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<Vector3<double>> point;
  for (int k = 0; k < points; ++k) {
    const Vector3<double> axis = matrix_of(any_turn(random)).y;
    const auto as_float = [](double x) { return static_cast<double>(static_cast<float>(x)); };
    point.push_back({as_float(axis.x / 2), as_float(axis.y / 2), as_float(axis.z / 2)});
  }
  return make_hull(shapes.hulls, point);
}

// Shapes on and about slanted planes. Some lie flat.
void random_pairs(int count, std::uint32_t seed, Shapes& shapes, Pairs& pairs) {
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const int balls[] = {ball(shapes, 4, 1), ball(shapes, 12, 2), ball(shapes, 64, 3)};
  for (int k = 0; k < count; ++k) {
    const Quaternion<double> slant = any_turn(random);
    const Vector3<double> origin = {uniform(-3, 3), uniform(-3, 3), uniform(-3, 3)};
    const Pose<double> pose =
        at(origin + matrix_of(slant) * Vector3<double>{uniform(-2, 2), uniform(-.5, 1.5), uniform(-2, 2)},
           k % 3 ? any_turn(random) : slant);
    const bool plane_first = k % 2 == 0;
    if (plane_first) shapes.plane(at(origin, slant));
    const int kind = random() % 4;
    if (kind == 0) shapes.sphere(uniform(.05, 1), pose);
    if (kind == 1) shapes.capsule(k % 5 ? uniform(.05, 1) : 0, uniform(.05, .5), pose);
    if (kind == 2) shapes.box({uniform(.05, 1), uniform(.05, 1), uniform(.05, 1)}, pose);
    if (kind == 3) shapes.hull(balls[random() % 3], pose);
    if (!plane_first) shapes.plane(at(origin, slant));
    pairs.push_back({2 * k, 2 * k + 1});
  }
}

// Properties of the points, each from the corners as the oracle has them:
//   - there are points exactly where the lowest corner is within the margin, and it is among them
//   - each point's separation is its own corner's height less the radius, and it is midway between surface and plane
//   - no two have the same corner; the normal points from a to b
//   - at most 4; no more than one from one corner, two from two; and they span at least half the area of any triangle
//     of corners within the margin: with the second point at distance l and the others w and v to both sides of the
//     line to it, all such corners are within l of the first and w and v of the line, so that a triangle of them has l
//     (w + v) at most, and the points span half of that
// Rounding: coordinates of some 4, in float, 1e-6; twice that for margins.
template <class Real>
void expect_right(const Shapes& shapes, const Pair& pair, double margin, const Manifold<Real>& m) {
  const bool turned = static_cast<Kind>(shapes.colliders.kind[pair.b]) == Kind::plane;
  const int plane = turned ? pair.b : pair.a, convex = turned ? pair.a : pair.b;
  const Pose<double>& pose = shapes.pose[plane];
  const Vector3<double> normal = matrix_of(pose.orientation).y;
  const ExactShape shape = exact_collider(Placed<double>{shapes.colliders, shapes.hulls, shapes.pose}, convex);
  const auto height = [&](int v) { return dot(normal, shape.vertex[v] - pose.position) - shape.radius; };
  const int count = static_cast<int>(shape.vertex.size());
  double lowest = 1e9;
  std::vector<int> near;
  for (int v = 0; v < count; ++v) {
    lowest = std::min(lowest, height(v));
    if (height(v) <= margin - 2e-6) near.push_back(v);
  }
  if (std::abs(lowest - margin) < 2e-6) return;
  ASSERT_EQ(m.count > 0, lowest <= margin);
  ASSERT_EQ(m.a, pair.a);
  ASSERT_EQ(m.b, pair.b);
  if (m.count == 0) return;
  ASSERT_NEAR(length(in_double(m.normal) - (turned ? -normal : normal)), 0, 1e-6);
  ASSERT_LE(m.count, std::min(most_points, count));
  ASSERT_NEAR(m.point[0].separation, lowest, 2e-6);
  std::set<int> features;
  for (int k = 0; k < m.count; ++k) {
    const int v = m.feature[k];
    ASSERT_TRUE(v >= 0 && v < count && features.insert(v).second);
    ASSERT_NEAR(m.point[k].separation, height(v), 2e-6);
    const Vector3<double> middle = shape.vertex[v] - (shape.radius + height(v) / 2) * normal;
    ASSERT_NEAR(length(in_double(m.point[k].position) - middle), 0, 4e-6);
  }
  for (int k = m.count; k < most_points; ++k) ASSERT_TRUE(m.point[k].separation == 0 && m.feature[k] == 0);

  const auto area = [&](int i, int j, int k) {
    return std::abs(dot(normal, cross(shape.vertex[j] - shape.vertex[i], shape.vertex[k] - shape.vertex[i]))) / 2;
  };
  double largest = 0, spanned = 0;
  for (const int i : near)
    for (const int j : near)
      for (const int k : near)
        if (i < j && j < k) largest = std::max(largest, area(i, j, k));
  if (m.count >= 3) spanned = area(m.feature[0], m.feature[1], m.feature[2]);
  if (m.count == 4) spanned += area(m.feature[0], m.feature[1], m.feature[3]);
  ASSERT_GE(spanned, largest / 2 - 1e-5);
}

TEST(RigidPlanes, HaveTheRightPoints) {
  Shapes shapes;
  Pairs pairs;
  random_pairs(3000, 1, shapes, pairs);
  for (const double margin : {0., .05, .3}) {
    const std::vector<Manifold<float>> m = collide<float>(shapes, pairs, margin);
    const std::vector<Manifold<double>> n = collide<double>(shapes, pairs, margin);
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      SCOPED_TRACE("pair " + std::to_string(k));
      expect_right(shapes, pairs[k], margin, m[k]);
      expect_right(shapes, pairs[k], margin, n[k]);
      if (HasFatalFailure()) return;
    }
  }
}

TEST(RigidPlanes, KeepClosedForms) {
  const double quarter = std::numbers::pi / 2;
  Shapes shapes;
  const int floor = shapes.plane(at({0, 1, 0}));
  const int sphere = shapes.sphere(.5, at({3, 1.25, 4})),
            lying = shapes.capsule(1, .25, at({0, 1.25, 0}, turn({0, 0, 1}, quarter)));
  const int standing = shapes.capsule(1, .25, at({0, 2, 0})), box = shapes.box({1, .5, 2}, at({0, 1.25, 0}));
  const int aslant = shapes.box({1, 1, 1}, at({0, 2.4, 0}, turn({1, 0, 0}, quarter / 2))),
            above = shapes.sphere(1, at({0, 2.125, 0}));
  const int point = shapes.capsule(0, .25, at({0, 1, 0}));
  const std::vector<Manifold<double>> m = collide<double>(shapes,
                                                          {{floor, sphere},
                                                           {floor, lying},
                                                           {floor, standing},
                                                           {floor, box},
                                                           {floor, aslant},
                                                           {floor, above},
                                                           {floor, point}},
                                                          .1);
  ASSERT_EQ(m[0].count, 1);
  EXPECT_NEAR(m[0].point[0].separation, -.25, 1e-12);
  EXPECT_NEAR(m[0].point[0].position.y, .875, 1e-12);
  EXPECT_NEAR(m[0].point[0].position.x, 3, 1e-12);
  EXPECT_EQ(m[1].count, 2);
  EXPECT_NEAR(std::abs(m[1].point[0].position.x - m[1].point[1].position.x), 2, 1e-6);
  EXPECT_EQ(m[2].count, 1);
  ASSERT_EQ(m[3].count, 4);
  for (int k = 0; k < 4; ++k) {
    EXPECT_NEAR(m[3].point[k].separation, -.25, 1e-12);
    EXPECT_NEAR(std::abs(m[3].point[k].position.x), 1, 1e-12);
    EXPECT_NEAR(std::abs(m[3].point[k].position.z), 2, 1e-12);
  }
  EXPECT_EQ(m[3].feature[0], 0);  // all are as deep: the lowest number
  EXPECT_EQ(m[4].count, 2);       // on an edge
  EXPECT_EQ(m[5].count, 0);
  EXPECT_EQ(m[6].count, 1);  // a capsule of no length: its corners are one
}

// Corners above one another are one, also where all are within the margin.
TEST(RigidPlanes, LeaveOutCornersAboveOthers) {
  Shapes shapes;
  const int floor = shapes.plane(at({0, 0, 0})), die = shapes.box({.01, .01, .01}, at({0, .01, 0})),
            pin = shapes.capsule(.01, .01, at({0, .02, 0}));
  const std::vector<Manifold<float>> m = collide<float>(shapes, {{floor, die}, {floor, pin}}, 1);
  ASSERT_EQ(m[0].count, 4);
  std::set<std::pair<bool, bool>> where;
  for (int k = 0; k < 4; ++k) where.insert({m[0].point[k].position.x > 0, m[0].point[k].position.z > 0});
  EXPECT_EQ(where.size(), 4u);
  EXPECT_EQ(m[1].count, 1);
}

TEST(RigidPlanes, AreBitwiseTheSameInParallel) {
  Shapes shapes;
  Pairs pairs;
  random_pairs(3000, 4, shapes, pairs);
  const Rounded<float> rounded(shapes);
  const int before = omp_get_max_threads();
  for (const float margin : {0.f, .05f, .5f})
    for (const std::size_t count :
         {std::size_t(0), std::size_t(1), std::size_t(15), std::size_t(16), std::size_t(17), pairs.size()}) {
      const std::span<const Pair> some(pairs.data(), count);
      std::vector<Manifold<float>> expected(count);
      serial::planes(rounded.placed(), some, margin, expected);
      for (const int threads : {1, 2, 3, 8}) {
        omp_set_num_threads(threads);
        std::vector<Manifold<float>> manifolds(count);
        openmp::planes(rounded.placed(), some, margin, manifolds);
        for (std::size_t k = 0; k < count; ++k)
          ASSERT_EQ(std::memcmp(&manifolds[k], &expected[k], sizeof(Manifold<float>)), 0)
              << k << " of " << count << ", margin " << margin;
      }
    }
  omp_set_num_threads(before);
}

}  // namespace
}  // namespace lockstep::rigid
