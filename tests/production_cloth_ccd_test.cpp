// Continuous collision detection: cases by hand, and what holds of any pair.
#include "common/production_cloth/ccd.h"

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "common/production_cloth/ccd_nearest.h"
#include "tests/production_cloth_ccd_pairs.h"

namespace lockstep::production_cloth {
namespace {

constexpr double never = -1;

// Corners of a triangle in the plane y = 0, turned so that its normal is +y or -y; and an edge along x there.
constexpr Vector3<double> a = {0, 0, 0}, b = {1, 0, 0}, c = {0, 0, 1};

CcdPair falling_point(Vector3<double> from, Vector3<double> to) { return {false, {from, a, b, c}, {to, a, b, c}}; }
CcdPair moving_edge(Vector3<double> p, Vector3<double> q, Vector3<double> by) {
  return {true, {p, q, a, b}, {p + by, q + by, a, b}};
}

struct ImpactByHand {
  double time;
  std::array<double, 4> weight;
  Vector3<double> normal;
};

// The one impact, if any, and the same of float and double, serial and openmp.
ImpactByHand impact_of(const CcdPair& pair) {
  const Contacts<double> wide = serial_impacts(make_ccd_world<double>({pair}));
  const CcdWorld<float> world = make_ccd_world<float>({pair});
  for (const Contacts<float>& impacts : {serial_impacts(world), openmp_impacts(world)}) {
    EXPECT_EQ(impacts.count, wide.count);
    for (std::size_t i = 0; i < 4 * std::min(wide.count, impacts.count); ++i) {
      EXPECT_EQ(impacts.corner[i], wide.corner[i]);
      EXPECT_EQ(impacts.weight[i], static_cast<float>(wide.weight[i]));  // all hold where positions are floats
      EXPECT_EQ(impacts.normal[i], static_cast<float>(wide.normal[i]));
    }
  }
  if (wide.count == 0) return {never, {}, {}};
  EXPECT_EQ(wide.count, 1);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(wide.corner[i], i);
  const auto &w = wide.weight, &n = wide.normal;
  return {n[3], {w[0], w[1], w[2], w[3]}, {n[0], n[1], n[2]}};
}
void expect_impact(const CcdPair& pair, const ImpactByHand& expected, double error = 1e-14) {
  const ImpactByHand impact = impact_of(pair);
  EXPECT_NEAR(impact.time, expected.time, error);
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(impact.weight[i], expected.weight[i], error) << i;
  EXPECT_NEAR(impact.normal.x, expected.normal.x, error);
  EXPECT_NEAR(impact.normal.y, expected.normal.y, error);
  EXPECT_NEAR(impact.normal.z, expected.normal.z, error);
}

TEST(ProductionClothCcd, APointFallsOntoATriangle) {
  expect_impact(falling_point({.25, 1, .5}, {.25, -1, .5}), {.5, {1, -.25, -.25, -.5}, {0, 1, 0}});
  expect_impact(falling_point({.25, -.5, .5}, {.25, 1.5, .5}), {.25, {1, -.25, -.25, -.5}, {0, -1, 0}});
}

TEST(ProductionClothCcd, EdgesCross) {
  expect_impact(moving_edge({.25, 1, -1}, {.25, 1, 3}, {0, -4, 0}), {.25, {.75, .25, -.75, -.25}, {0, 1, 0}});
  expect_impact(moving_edge({.25, -3, -1}, {.25, -3, 3}, {0, 4, 0}), {.75, {.75, .25, -.75, -.25}, {0, -1, 0}});
}

TEST(ProductionClothCcd, WhatPassesByALittleDoesNotMeet) {
  constexpr double little = 0x1p-20;
  EXPECT_EQ(impact_of(falling_point({.25, 1, -little}, {.25, -1, -little})).time, never);
  EXPECT_EQ(impact_of(falling_point({.5 + little, 1, .5}, {.5 + little, -1, .5})).time, never);
  EXPECT_EQ(impact_of(falling_point({.25, 1, .5}, {.25, little, .5})).time, never);
  EXPECT_EQ(impact_of(moving_edge({.25, 1, little}, {.25, 1, 1}, {0, -4, 0})).time, never);
  EXPECT_EQ(impact_of(moving_edge({1 + little, 1, -1}, {1 + little, 1, 1}, {0, -4, 0})).time, never);
  EXPECT_NE(impact_of(falling_point({.25, 1, little}, {.25, -1, little})).time, never);
  EXPECT_NE(impact_of(moving_edge({.25, 1, -little}, {.25, 1, 1}, {0, -4, 0})).time, never);
}

// At corners, on sides and at ends, where weights are 0.
TEST(ProductionClothCcd, BordersBelongToTheElements) {
  for (const Vector3<double>& p : {a, b, c, .5 * (a + b), .5 * (b + c), .5 * (c + a)})
    EXPECT_NEAR(impact_of(falling_point(p + Vector3<double>{0, 1, 0}, p - Vector3<double>{0, 1, 0})).time, .5, 1e-7);
  EXPECT_NEAR(impact_of(moving_edge({0, 1, 0}, {0, 1, 1}, {0, -4, 0})).time, .25, 1e-7);
  EXPECT_NEAR(impact_of(moving_edge({1, 1, -1}, {1, 1, 0}, {0, -4, 0})).time, .25, 1e-7);
}

TEST(ProductionClothCcd, BothEndsOfTheStepBelongToIt) {
  expect_impact(falling_point({.25, 0, .5}, {.25, -1, .5}), {0, {1, -.25, -.25, -.5}, {0, 1, 0}});
  expect_impact(falling_point({.25, 0, .5}, {.25, 1, .5}), {0, {1, -.25, -.25, -.5}, {0, -1, 0}});
  expect_impact(falling_point({.25, 1, .5}, {.25, 0, .5}), {1, {1, -.25, -.25, -.5}, {0, 1, 0}});
  expect_impact(moving_edge({.25, 0, -1}, {.25, 0, 3}, {0, -4, 0}), {0, {.75, .25, -.75, -.25}, {0, 1, 0}});
  expect_impact(moving_edge({.25, 4, -1}, {.25, 4, 3}, {0, -4, 0}), {1, {.75, .25, -.75, -.25}, {0, 1, 0}});
}

TEST(ProductionClothCcd, WhatRestsInTouchHasAnImpactAtOnceAndAUnitNormal) {
  const ImpactByHand impact = impact_of(falling_point({.25, 0, .5}, {.25, 0, .5}));
  EXPECT_EQ(impact.time, 0);
  EXPECT_EQ(std::abs(impact.normal.y), 1);
  const ImpactByHand one_point = impact_of({true, {a, a, a, a}, {a, a, a, a}});
  EXPECT_EQ(one_point.time, 0);
  EXPECT_EQ(dot(one_point.normal, one_point.normal), 1);
}

// Where the cubic is 0 all the time. Conservative advancement ends within the tolerance, 2^-26 of the extent.
TEST(ProductionClothCcd, MotionInTheCommonPlane) {
  const double error = 0x1p-22;
  expect_impact(falling_point({.25, 0, -1}, {.25, 0, 1}), {.5, {1, -.75, -.25, 0}, {0, 0, -1}}, error);
  EXPECT_EQ(impact_of(falling_point({-1, 0, -1}, {-1, 0, 1})).time, never);
  EXPECT_EQ(impact_of(falling_point({-1, 0, .5}, {1, 0, -1.5})).time, never);  // past the corner a
  expect_impact(moving_edge({.25, 0, -2}, {.25, 0, -1}, {0, 0, 4}), {.25, {0, 1, -.75, -.25}, {0, 0, -1}}, error);
  EXPECT_EQ(impact_of(moving_edge({2, 0, -2}, {2, 0, -1}, {0, 0, 4})).time, never);
}

TEST(ProductionClothCcd, ParallelEdges) {
  const ImpactByHand impact = impact_of(moving_edge({.5, 1, 0}, {2, 1, 0}, {0, -4, 0}));
  EXPECT_NEAR(impact.time, .25, 0x1p-24);
  EXPECT_NEAR(impact.normal.y, 1, 1e-6);
  EXPECT_EQ(impact_of(moving_edge({1.5, 1, 0}, {2, 1, 0}, {0, -4, 0})).time, never);
  const ImpactByHand in_line = impact_of(moving_edge({2, 0, 0}, {3, 0, 0}, {-2, 0, 0}));
  EXPECT_NEAR(in_line.time, .5, 0x1p-24);
  EXPECT_NEAR(in_line.normal.x, 1, 1e-6);
}

TEST(ProductionClothCcd, ATriangleThatIsALine) {
  const Vector3<double> middle = .5 * (a + b), up = {0, 1, 0};
  const auto through = [&](const Vector3<double>& p) {
    return CcdPair{false, {p + up, a, middle, b}, {p - up, a, middle, b}};
  };
  EXPECT_NEAR(impact_of(through({.25, 0, 0})).time, .5, 0x1p-22);
  EXPECT_EQ(impact_of(through({.25, 0, .125})).time, never);
  EXPECT_EQ(impact_of(through({1.125, 0, 0})).time, never);
}

// The plane's cubic touches 0 without crossing it: at t = 1/2, where the edge that turns over lies on the other.
TEST(ProductionClothCcd, DoubleRoot) {
  const CcdPair pair = {
      true, {{{-1, 1, 0}, {1, 1, 0}, {-1, 0, -1}, {1, 0, 1}}}, {{{-1, -1, 0}, {1, -1, 0}, {-1, 0, 1}, {1, 0, -1}}}};
  EXPECT_NEAR(impact_of(pair).time, .5, 0x1p-22);
}

TEST(ProductionClothCcd, WhatMovesAlikeDoesNotMeet) {
  CcdRandom random;
  const Vector3<double> by = {3, -2, 1};
  for (int k = 0; k < 100; ++k) {
    CcdPair pair = random.pair(k % 2, 1, 0);
    for (int i = 0; i < 4; ++i) pair.end[i] = pair.start[i] + by;
    EXPECT_EQ(impact_of(pair).time != never, CcdOracle(pair, 1e-9).may_meet(0)) << k;
  }
}

TEST(ProductionClothCcd, OrderOfVerticesDoesNotMatter) {
  CcdRandom random;
  int met = 0;
  for (int k = 0; k < 1000; ++k) {
    const CcdPair pair = random.pair(k % 2, 1, 2);
    const auto permuted = [&](const std::array<int, 4>& of) {
      CcdPair other = pair;
      for (int i = 0; i < 4; ++i) other.start[i] = pair.start[of[i]], other.end[i] = pair.end[of[i]];
      return other;
    };
    const ImpactByHand impact = impact_of(pair);
    met += impact.time != never;
    const auto same = [&](const std::array<int, 4>& of, double sign) {
      const ImpactByHand other = impact_of(permuted(of));
      EXPECT_NEAR(other.time, impact.time, 1e-9) << k;
      if (other.time == never || impact.time == never) return;
      for (int i = 0; i < 4; ++i) EXPECT_NEAR(other.weight[i], sign * impact.weight[of[i]], 1e-6) << k;
      EXPECT_NEAR(dot(other.normal, impact.normal), sign, 1e-6) << k;
    };
    if (pair.edges)
      same({2, 3, 0, 1}, -1), same({1, 0, 2, 3}, 1), same({0, 1, 3, 2}, 1);
    else
      same({0, 2, 3, 1}, 1), same({0, 1, 3, 2}, 1);
  }
  EXPECT_GT(met, 40);
}

}  // namespace
}  // namespace lockstep::production_cloth
