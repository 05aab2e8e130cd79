// Box against box: closed forms, both versions bit by bit, and pairs in the other order.
// tests/rigid_box_box_exact_test.cpp compares with the exact oracle.
#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include "tests/rigid_box_pairs.h"

namespace lockstep::rigid::box_pairs {
namespace {

// ---- closed forms

struct OnePair {
  Pose<float> a, b;
  Vector3<float> half_a, half_b;
  Manifold<float> collide(float margin) const {
    Boxes<float> boxes;
    boxes.add(a, half_a), boxes.add(b, half_b);
    return run<float>(serial::box_box, boxes, margin, 1)[0];
  }
};
Pose<float> at(double x, double y, double z, const Quaternion<double>& q = {0, 0, 0, 1}) {
  return rounded<float>({{x, y, z}, q, 0});
}

TEST(BoxBox, AlignedBoxesTouchInTheRectangleTheyShare) {
  const OnePair pair = {at(0, 0, 0), at(.5f, 1.75f, .25f), {1, 1, 1}, {1, .875f, .5f}};  // .125 deep, along y
  const Manifold<float> m = pair.collide(0);
  ASSERT_EQ(m.count, 4);
  EXPECT_EQ(m.normal.x, 0);
  EXPECT_EQ(m.normal.y, 1);
  EXPECT_EQ(m.normal.z, 0);
  float low_x = 9, high_x = -9, low_z = 9, high_z = -9;
  for (int k = 0; k < 4; ++k) {
    const auto& [p, separation] = m.point[k];
    EXPECT_EQ(separation, -.125f);
    EXPECT_EQ(p.y, 1 - .0625f);
    low_x = std::min(low_x, p.x), high_x = std::max(high_x, p.x), low_z = std::min(low_z, p.z),
    high_z = std::max(high_z, p.z);
  }
  EXPECT_NEAR(low_x, -.5f, 5e-6);
  EXPECT_NEAR(high_x, 1, 5e-6);
  EXPECT_NEAR(low_z, -.25f, 5e-6);
  EXPECT_NEAR(high_z, .75f, 5e-6);
}

TEST(BoxBox, TouchingIsContactAndAHairApartIsNot) {
  for (const float gap : {0.f, 1e-6f, .01f}) {
    const OnePair pair = {at(0, 0, 0), at(0, 2 + gap, 0), {1, 1, 1}, {1, 1, 1}};
    EXPECT_EQ(pair.collide(0).count, gap > 0 ? 0 : 4) << gap;
    const Manifold<float> m = pair.collide(.02f);
    ASSERT_EQ(m.count, 4) << gap;
    for (int k = 0; k < 4; ++k) EXPECT_NEAR(m.point[k].separation, gap, 1e-6);
  }
}

TEST(BoxBox, CrossedEdgesTouchInOnePoint) {
  // Two square beams, edge on edge, one along x and one along z: sqrt(2) each from centre to edge.
  const float up = 2 * std::sqrt(2.f) - .125f;
  const OnePair pair = {
      at(0, 0, 0, about({1, 0, 0}, pi / 4)), at(.25f, up, .5f, about({0, 0, 1}, pi / 4)), {3, 1, 1}, {1, 1, 3}};
  const Manifold<float> m = pair.collide(0);
  ASSERT_EQ(m.count, 1);
  EXPECT_NEAR(m.normal.y, 1, 1e-6);
  EXPECT_NEAR(m.point[0].separation, -.125, 1e-6);
  EXPECT_NEAR(m.point[0].position.x, .25, 2e-6);
  EXPECT_NEAR(m.point[0].position.y, std::sqrt(2.) - .0625, 2e-6);
  EXPECT_NEAR(m.point[0].position.z, 0, 2e-6);
}

TEST(BoxBox, ACornerInAFaceIsOnePoint) {
  // A cube on its corner: the diagonal is upright.
  const Quaternion<double> upright = about({1, 0, -1}, std::acos(1 / std::sqrt(3.)));
  const OnePair pair = {
      at(0, 0, 0), at(.25f, 1 + .5f * std::sqrt(3.f) - .0625f, .125f, upright), {1, 1, 1}, {.5f, .5f, .5f}};
  const Manifold<float> m = pair.collide(0);
  EXPECT_NEAR(m.normal.y, 1, 1e-6);
  float least = 1;
  for (int k = 0; k < m.count; ++k)
    if (m.point[k].separation < least) {
      least = m.point[k].separation;
      EXPECT_NEAR(m.point[k].position.x, .25, 1e-5);
      EXPECT_NEAR(m.point[k].position.z, .125, 1e-5);
    }
  EXPECT_NEAR(least, -.0625, 1e-6);
}

// A resting box keeps its four points, far apart, while its pose trembles. On a larger box it also keeps their
// features.
TEST(BoxBox, AStackDoesNotFlicker) {
  Random random{std::mt19937(5)};
  std::int32_t features[4] = {-1, -1, -1, -1};
  for (int step = 0; step < 4000; ++step) {
    const bool larger = step % 2;
    const double trembling = step % 4 < 2 ? 1e-6 : 1e-3;
    const Quaternion<double> q = about(random.direction(), random.within(0, trembling)) * about({0, 1, 0}, .3);
    const Vector away = random.vector(trembling);
    const float side = larger ? 1 : .5f;
    const OnePair pair = {at(0, 0, 0), at(away.x, .98 + away.y, away.z, q), {side, .5f, side}, {.5f, .5f, .5f}};
    const Manifold<float> m = pair.collide(.02f);
    ASSERT_EQ(m.count, 4) << step;
    double low_x = 1, high_x = -1, low_z = 1, high_z = -1;
    for (int k = 0; k < 4; ++k) {
      const auto& p = m.point[k].position;
      low_x = std::min<double>(low_x, p.x), high_x = std::max<double>(high_x, p.x);
      low_z = std::min<double>(low_z, p.z), high_z = std::max<double>(high_z, p.z);
      if (larger && step > 1) {
        ASSERT_EQ(m.feature[k], features[k]) << step;
      }
      if (larger) features[k] = m.feature[k];
    }
    for (const double reach : {-low_x, high_x, -low_z, high_z}) ASSERT_GT(reach, .3) << step;
  }
}

// ---- the other version, and the other order

void expect_same(const Array<Manifold<float>>& expected, const Array<Manifold<float>>& found) {
  ASSERT_EQ(expected.size(), found.size());
  for (std::size_t k = 0; k < expected.size(); ++k) {
    ASSERT_EQ(expected[k].count, found[k].count) << k;
    if (expected[k].count > 0) {
      ASSERT_EQ(std::memcmp(&expected[k], &found[k], sizeof(expected[k])), 0) << k;
    }
  }
}

TEST(BoxBox, BothVersionsGiveTheSameBits) {
  const Boxes<float> boxes = random_boxes(random_pairs, 4);
  for (const float margin : {0.f, .05f}) {
    const Array<Manifold<float>> serial = run<float>(serial::box_box, boxes, margin, boxes.pairs.size());
    for (const int threads : {1, 2, 3, 8}) {
      omp_set_num_threads(threads);
      expect_same(serial, run<float>(openmp::box_box, boxes, margin, boxes.pairs.size()));
      for (const std::size_t count : {0, 1, 2, 15, 16, 17, 33, 300})
        expect_same(run<float>(serial::box_box, boxes, margin, count),
                    run<float>(openmp::box_box, boxes, margin, count));
    }
  }
  omp_set_num_threads(omp_get_num_procs());
}

// Pairs in the other order have the same depth and the opposite normal. They have the same points unless rounding
// decides between two.
TEST(BoxBox, SwappingMirrors) {
  const Boxes<float> boxes = random_boxes(random_pairs / 4, 6);
  Boxes<float> other;
  for (const Pair& pair : boxes.pairs)
    for (const int i : {pair.b, pair.a}) other.add(boxes.pose[i], boxes.half(i));
  const Array<Manifold<float>> there = run<float>(serial::box_box, boxes, .05f, boxes.pairs.size());
  const Array<Manifold<float>> back = run<float>(serial::box_box, other, .05f, boxes.pairs.size());
  int same_axis = 0, same_points = 0;
  for (std::size_t k = 0; k < there.size(); ++k) {
    const Manifold<float>&m = there[k], &n = back[k];
    const double size = boxes.size(k), bound = depth_bound * size;
    if (m.count == 0 || n.count == 0) {  // neither has points, or the boxes are as far apart as the margin
      for (int p = 0; p < std::max(m.count, n.count); ++p) {
        ASSERT_NEAR((m.count > 0 ? m : n).point[p].separation, .05f, bound) << k;
      }
      continue;
    }
    const Vector sum = vector_of(m.normal) + vector_of(n.normal);
    float deepest_m = 1e30f, deepest_n = 1e30f;
    for (int p = 0; p < m.count; ++p) deepest_m = std::min(deepest_m, m.point[p].separation);
    for (int p = 0; p < n.count; ++p) deepest_n = std::min(deepest_n, n.point[p].separation);
    if (deepest_m <= 0) {
      ASSERT_NEAR(deepest_m, deepest_n, 2 * bound) << k;
    }
    if (length(sum) > 1e-5) continue;  // two axes are equally good
    ++same_axis;
    const double near = 1e-4 * size;
    const auto has = [&](const Manifold<float>& manifold, const ContactPoint<float>& point) {
      for (int p = 0; p < manifold.count; ++p)
        if (length(vector_of(manifold.point[p].position) - vector_of(point.position)) < near &&
            std::abs(manifold.point[p].separation - point.separation) < near)
          return true;
      return false;
    };
    bool same = m.count == n.count;
    for (int p = 0; p < m.count; ++p) same = same && has(n, m.point[p]);
    same_points += same;
  }
  EXPECT_GT(same_axis, random_pairs / 4 / 3);
  EXPECT_GT(same_points, same_axis * .95);  // for equally deep or equally far points the order of slots decides
}

}  // namespace
}  // namespace lockstep::rigid::box_pairs
