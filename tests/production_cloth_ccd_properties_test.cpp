// Continuous collision detection of random pairs: against an oracle without roots, what an impact must be, both twins
// alike, and the rounding bounds of the filters.
#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "common/production_cloth/ccd_nearest.h"
#include "tests/production_cloth_ccd_pairs.h"

namespace lockstep::production_cloth {
namespace {

std::vector<CcdPair> random_pairs(int n, double size, double motion) {
  CcdRandom random;
  std::vector<CcdPair> pairs;
  for (int k = 0; k < n; ++k) pairs.push_back(random.pair(2 * k >= n, size, motion));
  return pairs;
}

// Which pairs have an impact, by their first vertex.
template <class Real>
std::vector<int> impact_of_pair(const Contacts<Real>& impacts, int pairs) {
  std::vector<int> of(pairs, -1);
  for (std::size_t k = 0; k < impacts.count; ++k) of[impacts.corner[4 * k] / 4] = static_cast<int>(k);
  return of;
}

// The oracle's distance is above the tolerance, 2^-26 of extents below 8, and of no other pair here is the answer in
// between. Nothing that meets is missed, and the first meeting is found: nothing is there earlier.
TEST(ProductionClothCcdProperties, AgreesWithAnOracleWithoutRoots) {
  constexpr int n = 2000;
  for (const double motion : {.5, 1., 4.}) {
    const std::vector<CcdPair> pairs = random_pairs(n, 1, motion);
    const Contacts<double> impacts = serial_impacts(make_ccd_world<double>(pairs));
    const std::vector<int> impact = impact_of_pair(impacts, n);
    for (int k = 0; k < n; ++k) {
      const CcdOracle oracle(pairs[k], 1e-6);
      EXPECT_EQ(impact[k] >= 0, oracle.may_meet()) << k;
      if (impact[k] < 0) continue;
      const double time = impacts.normal[4 * impact[k] + 3];
      EXPECT_FALSE(time > 1e-3 && oracle.may_meet(time - 1e-3)) << k;
    }
    EXPECT_GT(impacts.count, 40u);  // so that there is something to compare
  }
}

// Pairs that are made to meet: in general position, in a common plane, edges parallel; in double, to rounding.
TEST(ProductionClothCcdProperties, WhatIsMadeToMeetIsFound) {
  CcdRandom random;
  for (int k = 0; k < 3000; ++k) {
    CcdPair pair = random.pair(k % 2, 1, 1);
    const double time = .5 + .5 * random.number(), u = .5 + .5 * random.number(),
                 v = (.5 + .5 * random.number()) * (1 - u);
    if (k % 6 >= 4) pair.end[3] = pair.end[2] + (pair.end[1] - pair.end[0]);  // parallel at the end
    if (k % 3 == 0)
      for (int i = 0; i < 4; ++i) pair.start[i].y = pair.end[i].y = pair.start[0].x;  // in one plane
    const std::array<double, 4> weight =
        pair.edges ? std::array{1 - u, u, v - 1, -v} : std::array{1., u + v - 1, -u, -v};
    const Vector3<double> apart = apart_at(pair, time, weight);
    for (int i = 0; i < (pair.edges ? 2 : 1); ++i)
      pair.start[i] = pair.start[i] - apart, pair.end[i] = pair.end[i] - apart;
    const Contacts<double> impacts = serial_impacts(make_ccd_world<double>({pair}));
    ASSERT_EQ(impacts.count, 1) << k;
    EXPECT_LE(impacts.normal[3], time + 1e-3) << k;
  }
}

// Weights of each element sum to 1, so all to 0; points meet; the normal has length 1, and the elements approach. The
// bounds: in double, the tolerance of 2^-26 of an extent below 8; in float, weights and the time are rounded besides,
// by 2^-25 at most, which moves points by no more than the extent and the speed (below 14).
template <class Real>
void expect_impacts_are_impacts(const std::vector<CcdPair>& pairs, double rounding) {
  const Contacts<Real> impacts = serial_impacts(make_ccd_world<Real>(pairs));
  ASSERT_GT(impacts.count, 100u);
  for (std::size_t k = 0; k < impacts.count; ++k) {
    const Real *w = &impacts.weight[4 * k], *n = &impacts.normal[4 * k];
    const CcdPair& pair = pairs[impacts.corner[4 * k] / 4];
    EXPECT_NEAR(double(w[0]) + w[1] + w[2] + w[3], 0, 4 * rounding);
    EXPECT_NEAR(pair.edges ? double(w[0]) + w[1] : double(w[0]), 1, 2 * rounding);
    for (int i = 0; i < 4; ++i) {
      const bool first = i < (pair.edges ? 2 : 1);
      EXPECT_GE(first ? w[i] : -w[i], -rounding);
    }
    EXPECT_TRUE(n[3] >= 0 && n[3] <= 1);
    const Vector3<double> apart = apart_at(pair, n[3], w);
    EXPECT_LE(std::sqrt(dot(apart, apart)), 8 * 0x1p-26 + (4 * 8 + 14) * rounding);
    const Vector3<double> normal = {n[0], n[1], n[2]};
    EXPECT_NEAR(dot(normal, normal), 1, 4 * rounding);
    const Vector3<double> velocity = apart_at(pair, 1, w) - apart_at(pair, 0, w);
    EXPECT_LE(dot(normal, velocity), 30 * rounding);
  }
}
TEST(ProductionClothCcdProperties, ImpactsAreImpacts) {
  for (const double motion : {.5, 2.}) {
    const std::vector<CcdPair> pairs = random_pairs(3000, 1, motion);
    expect_impacts_are_impacts<double>(pairs, 0x1p-52);
    expect_impacts_are_impacts<float>(pairs, 0x1p-25);
  }
}

template <class T>
void expect_same_bits(const Array<T>& a, const Array<T>& b, std::size_t n) {
  EXPECT_EQ(std::memcmp(a.data(), b.data(), n * sizeof(T)), 0);
}
// Every 64th of a kind meets. So a sample of those takes all for near.
std::vector<CcdPair> near_by_sample(std::vector<CcdPair> pairs) {
  const int n = static_cast<int>(pairs.size());
  const std::vector<int> impact = impact_of_pair(serial_impacts(make_ccd_world<float>(pairs)), n);
  for (const bool edges : {false, true}) {
    std::vector<CcdPair*> of_kind;
    std::vector<CcdPair> that_meet;
    for (int k = 0; k < n; ++k)
      if (pairs[k].edges == edges) {
        of_kind.push_back(&pairs[k]);
        if (impact[k] >= 0) that_meet.push_back(pairs[k]);
      }
    for (std::size_t k = 0; k < of_kind.size() && !that_meet.empty(); k += 64)
      *of_kind[k] = that_meet[k / 64 % that_meet.size()];
  }
  return pairs;
}

TEST(ProductionClothCcdProperties, TwinsAreBitwiseAlikeOnAnyThreadsAndAtTheEndsOfRanges) {
  const int threads = omp_get_max_threads();
  openmp::CcdMemory memory;  // kept: what an earlier call left must not matter
  Contacts<float> impacts;
  for (const int n : {5000, 0, 1, 2, 15, 16, 17, 30, 31, 32, 33, 34, 2047, 2048, 2049})
    for (const auto& pairs : {random_pairs(n, 1, 1), near_by_sample(random_pairs(n, 1, 1))})
      for (const int on : {1, 2, 3, 5}) {
        const CcdWorld<float> world = make_ccd_world<float>(pairs);
        const Contacts<float> expected = serial_impacts(world);
        omp_set_num_threads(on);
        openmp::ccd(world.topology, world.pairs, world.start, world.end, memory, impacts);
        ASSERT_EQ(impacts.count, expected.count);
        expect_same_bits(impacts.corner, expected.corner, 4 * expected.count);
        expect_same_bits(impacts.weight, expected.weight, 4 * expected.count);
        expect_same_bits(impacts.normal, expected.normal, 4 * expected.count);
        const auto before = [](int a, int b) { return a / 4 < b / 4; };  // here, the order of pairs is that of vertices
        EXPECT_TRUE(std::is_sorted(impacts.corner.begin(), impacts.corner.begin() + 4 * impacts.count, before));
      }
  omp_set_num_threads(threads);
}

// Floats of large coordinates and small differences, flat tetrahedra among them: the filter's numbers are as near to
// those in double, which are exact in comparison, as the bounds say.
TEST(ProductionClothCcdProperties, RoundingOfTheFiltersIsWithinItsBounds) {
  using namespace meeting;
  CcdRandom random;
  double worst_end = 0, worst_middle = 0;
  for (int k = 0; k < 100000; ++k) {
    const Vector3<double> far = std::ldexp(1, k % 8) * random.vector();
    Corners<float> x;
    for (int i = 0; i < 4; ++i)
      for (Vector3<float>* p : {&x.start[i], &x.end[i]}) {
        Vector3<double> q = random.vector();
        if (k % 3 == 0) q.y = .5 * q.x + .25 * q.z;
        const Vector3<double> at = far + q;
        *p = {static_cast<float>(at.x), static_cast<float>(at.y), static_cast<float>(at.z)};
      }
    Corners<double> wide;
    for (int i = 0; i < 4; ++i) {
      wide.start[i] = {x.start[i].x, x.start[i].y, x.start[i].z};
      wide.end[i] = {x.end[i].x, x.end[i].y, x.end[i].z};
    }
    const Cubic<float> f = cubic_of(spans_of(x));
    const Cubic<double> exact = cubic_of(spans_of(wide));
    worst_end = max(worst_end, max(abs(f.b0 - exact.b0), abs(f.b3 - exact.b3)) / rounding_of_end(f));
    worst_middle = max(worst_middle, max(abs(f.b1_3 - exact.b1_3), abs(f.b2_3 - exact.b2_3)) / rounding_of_middle(f));
    const bool never = exact.b0 * exact.b3 > 0 && exact.b0 * exact.b1_3 > 0 && exact.b0 * exact.b2_3 > 0;
    EXPECT_TRUE(never || !never_in_plane(f)) << k;
  }
  EXPECT_LE(worst_end, 1);
  EXPECT_LE(worst_middle, 1);
  EXPECT_GT(worst_end, .05);  // the bounds are no more than they must be, but for luck
  EXPECT_GT(worst_middle, .02);
}

// A filter that dismisses must be right: where the oracle finds a meeting, none may. And they are worth having.
TEST(ProductionClothCcdProperties, FiltersDismissNoPairThatMeets) {
  using namespace meeting;
  constexpr int n = 2000;
  const std::vector<CcdPair> pairs = random_pairs(n, 1, 1);
  int apart = 0, dismissed = 0;
  const auto count = [&]<Kind kind>(const CcdPair& pair) {
    Corners<double> x;
    for (int i = 0; i < 4; ++i) x.start[i] = pair.start[i], x.end[i] = pair.end[i];
    const Spans<double> spans = spans_of(x);
    const bool any_says =
        apart_along_axes<kind>(x) || never_in_plane(cubic_of(spans)) || apart_in_quarters<kind>(spans);
    const bool meets = CcdOracle(pair, 1e-7).may_meet();
    EXPECT_FALSE(any_says && meets);
    apart += !meets, dismissed += any_says;
  };
  for (const CcdPair& pair : pairs)
    if (pair.edges)
      count.template operator()<Kind::edge_edge>(pair);
    else
      count.template operator()<Kind::point_triangle>(pair);
  EXPECT_GT(dismissed, apart * 9 / 10);
}

}  // namespace
}  // namespace lockstep::production_cloth
