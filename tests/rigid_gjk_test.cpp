// Closest points of convex cores: closed forms, the exact oracle (exact_convex.h), symmetry, any start, no NaN, and
// both versions bit by bit. Overlap against an independent implementation is tested in
// tests/rigid_gjk_overlap_test.cpp.
#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include "tests/rigid_gjk.h"

namespace lockstep::rigid::gjk_pairs {
namespace {

// --- Closed forms

// The distance is right, the points are that far apart, and if only one pair of points is closest, these are the
// points.
template <class Real>
void expect_closest(const Shapes& shapes, double distance, const Vector* on_a = nullptr, const Vector* on_b = nullptr) {
  const Rounded<Real> rounded = round_shapes<Real>(shapes);
  const Pair pair = {0, 1};
  const double bound = good * unit_roundoff<Real> * measure(rounded.placed(), pair);
  const Closest<Real> c = run<Real>(serial::gjk, rounded.placed(), std::span(&pair, 1)).closest[0];
  EXPECT_NEAR(c.distance, distance, bound);
  EXPECT_NEAR(length(in_double(c.on_b) - in_double(c.on_a)), c.distance, bound);
  if (on_a) {
    EXPECT_LE(length(in_double(c.on_a) - *on_a), bound);
    EXPECT_LE(length(in_double(c.on_b) - *on_b), bound);
  }
}
void expect_closest(const Shapes& shapes, double distance) {
  expect_closest<float>(shapes, distance);
  expect_closest<double>(shapes, distance);
}
void expect_closest(const Shapes& shapes, double distance, const Vector& on_a, const Vector& on_b) {
  expect_closest<float>(shapes, distance, &on_a, &on_b);
  expect_closest<double>(shapes, distance, &on_a, &on_b);
}

// Turns without rounding: one from y to x, one from y to z.
constexpr Quaternion<double> along_x = {-.5, -.5, -.5, .5}, along_z = {.5, .5, .5, .5};

TEST(Gjk, Points) {
  Shapes apart, together;
  apart.sphere(.1, at({1, 2, 3})), apart.sphere(.1, at({3, 5, 9}));
  expect_closest(apart, 7, {1, 2, 3}, {3, 5, 9});
  together.sphere(.1, at({1, 2, 3})), together.sphere(.1, at({1, 2, 3}));
  expect_closest(together, 0, {1, 2, 3}, {1, 2, 3});
}

TEST(Gjk, Segments) {
  Shapes crossing, parallel, in_line, touching;
  crossing.capsule(1, .1, at({0, 0, 0})), crossing.capsule(1, .1, at({.25, .5, 2}, along_x));
  expect_closest(crossing, 2, {0, .5, 0}, {0, .5, 2});
  parallel.capsule(1, .1, at({0, 0, 0})), parallel.capsule(1, .1, at({3, .5, 4}));
  expect_closest(parallel, 5);
  in_line.capsule(1, .1, at({0, 0, 0})), in_line.capsule(.5, .1, at({0, 4, 0}));
  expect_closest(in_line, 2.5, {0, 1, 0}, {0, 3.5, 0});
  touching.capsule(1, .1, at({0, 0, 0})), touching.capsule(1, .1, at({.5, .25, 0}, along_x));
  expect_closest(touching, 0, {0, .25, 0}, {0, .25, 0});
}

TEST(Gjk, BoxesAlongTheAxes) {
  Shapes face, edge, corner, inside;
  for (Shapes* shapes : {&face, &edge, &corner, &inside}) shapes->box({.5, 1, 1.5}, at({1, 1, 1}));
  face.box({.5, .5, .5}, at({2.25, 1.5, .5}));
  expect_closest(face, .25);
  edge.box({.5, .5, .5}, at({5, 6.5, 1.25}));
  expect_closest(edge, 5);
  corner.box({.5, .5, .5}, at({3, 4.5, 9}));
  expect_closest(corner, std::hypot(1, 2, 6), {1.5, 2, 2.5}, {2.5, 4, 8.5});
  inside.box({.25, .25, .25}, at({1.125, 1, .75}));
  expect_closest(inside, 0);
}

TEST(Gjk, SegmentOverTriangle) {
  Shapes end, middle, through;
  const int triangle = add_vertices(end.hulls, {{0, 0, 0}, {4, 0, 0}, {0, 0, 4}});
  middle.hulls = through.hulls = end.hulls;
  for (Shapes* shapes : {&end, &middle, &through}) shapes->add(Kind::triangle, triangle, {1, 1, 1, 0}, at({1, 2, 3}));
  end.capsule(1, .1, at({2, 4, 4}));
  expect_closest(end, 1, {2, 2, 4}, {2, 3, 4});
  middle.capsule(2, .1, at({-2, 6, 5}, along_z));
  expect_closest(middle, 5);
  through.capsule(1, .1, at({2, 2.5, 4}));
  expect_closest(through, 0, {2, 2, 4}, {2, 2, 4});
}

// --- Against the exact oracle

template <class Real>
void expect_exact(int pairs) {
  Random random(1);
  const Scene scene = faced_kinds(random, pairs);
  const Rounded<Real> rounded = round_shapes<Real>(scene.shapes);
  const Placed<Real> placed = rounded.placed();
  const Answer<Real> answer = run<Real>(serial::gjk, placed, scene.pairs);
  int apart = 0;
  for (int k = 0; k < pairs; ++k) {
    const Pair& pair = scene.pairs[k];
    const ExactShape a = core(placed, pair.a), b = core(placed, pair.b);
    const double bound = good * unit_roundoff<Real> * measure(placed, pair);
    const double exact = exact_separation(a, b).separation;
    const Closest<Real>& c = answer.closest[k];
    ASSERT_NEAR(c.distance, std::max(exact, 0.), bound) << "pair " << k << ", " << c.iterations << " iterations";
    if (exact < bound) continue;
    ++apart;
    // A world coordinate is also rounded in proportion to the place of the pair, and by the turn.
    const double in_world =
        bound + 8 * unit_roundoff<Real> * (length(in_double(placed.pose[pair.a].position)) + measure(placed, pair));
    const Vector on_a = in_double(c.on_a), on_b = in_double(c.on_b);
    ASSERT_NEAR(length(on_b - on_a), c.distance, in_world) << "pair " << k;
    ASSERT_LE(exact_separation(a, exact_shape({on_a}, {})).separation, in_world) << "pair " << k;
    ASSERT_LE(exact_separation(b, exact_shape({on_b}, {})).separation, in_world) << "pair " << k;
  }
  EXPECT_GT(apart, pairs / 4);
}

TEST(Gjk, ExactDistanceInFloat) { expect_exact<float>(4000); }
TEST(Gjk, ExactDistanceInDouble) { expect_exact<double>(4000); }

// --- Symmetry, starts, degenerate input

TEST(Gjk, TurnedRoundTheDistanceIsTheSame) {
  Random random(3);
  const Scene scene = all_kinds(random, 20'000);
  const Rounded<float> rounded(scene.shapes);
  Pairs turned = scene.pairs;
  for (Pair& pair : turned) std::swap(pair.a, pair.b);
  const auto there = run<float>(serial::gjk, rounded.placed(), scene.pairs).closest;
  const auto back = run<float>(serial::gjk, rounded.placed(), turned).closest;
  for (std::size_t k = 0; k < turned.size(); ++k)
    ASSERT_NEAR(there[k].distance, back[k].distance,
                2 * (scene.has_thin(turned[k]) ? thin_good : good) * unit_roundoff<float> *
                    measure(rounded.placed(), turned[k]))
        << "pair " << k;
}

TEST(Gjk, AnyStartGivesTheSameDistance) {
  Random random(4);
  const Scene scene = all_kinds(random, 200'000);
  const Rounded<float> rounded(scene.shapes);
  const Placed<float> placed = rounded.placed();
  const auto [cold, known] = run<float>(serial::gjk, placed, scene.pairs);
  const auto [warm, known_too] = run<float>(serial::gjk, placed, scene.pairs, known);
  std::vector<Simplex> garbage(scene.pairs.size());
  for (std::size_t k = 0; k < garbage.size(); ++k) garbage[k] = any_simplex(random, placed, scene.pairs[k]);
  const auto [any, known_as_well] = run<float>(serial::gjk, placed, scene.pairs, garbage);
  int looks = 0;
  for (std::size_t k = 0; k < garbage.size(); ++k) {
    const Pair& pair = scene.pairs[k];
    const double bound = 2 * (scene.has_thin(pair) ? thin_good : good) * unit_roundoff<float> * measure(placed, pair);
    ASSERT_NEAR(cold[k].distance, warm[k].distance, bound) << "pair " << k;
    ASSERT_NEAR(cold[k].distance, any[k].distance, bound) << "pair " << k;
    ASSERT_GE(known[k].count, 1);
    ASSERT_LE(known[k].count, 4);
    looks += warm[k].iterations;
  }
  // A warm start takes one iteration, or none if the cores overlap.
  EXPECT_LT(looks, static_cast<int>(1.05 * garbage.size()));
}

// Shapes so small or so large that fourth powers of their sizes leave the range of float.
TEST(Gjk, NeverNan) {
  Random random(5);
  for (const double scale : {1e-30, 1e-18, 1e-12, 1e-9, 1e-6, 1e-3, 1., 1e3}) {
    Scene scene;
    for (int k = 0; k < 2000; ++k) {
      const auto add = [&](const Vector& position) {
        const Vector half = {any_below(random, 3) * .5 * scale, any_below(random, 3) * .5 * scale,
                             any_below(random, 3) * .5 * scale};
        return scene.shapes.box(half, at(position, any_below(random, 2) ? no_rotation : any_turn(random)));
      };
      const int a = add({0, 0, 0});
      scene.pair(a, add((any_below(random, 4) * scale) * any_direction(random)));
    }
    const Rounded<float> rounded(scene.shapes);
    for (Gjk<float>* gjk : {serial::gjk, openmp::gjk})
      for (const Closest<float>& c : run<float>(*gjk, rounded.placed(), scene.pairs).closest) {
        ASSERT_GE(c.distance, 0) << scale;
        ASSERT_TRUE(std::isfinite(length(in_double(c.on_a)) + length(in_double(c.on_b)) + c.distance)) << scale;
        ASSERT_LE(c.distance, 5 * scale);
      }
  }
}

// --- Bit by bit

TEST(Gjk, BothVersionsHaveTheSameBits) {
  Random random(6);
  const Scene scene = all_kinds(random, 6000);
  const Rounded<float> rounded(scene.shapes);
  const Placed<float> placed = rounded.placed();
  std::vector<Simplex> cold(scene.pairs.size()), garbage = cold;
  for (std::size_t k = 0; k < garbage.size(); ++k) garbage[k] = any_simplex(random, placed, scene.pairs[k]);
  const int threads_before = omp_get_max_threads();
  for (const std::size_t count : {0, 1, 15, 16, 17, 513, 6000}) {
    const std::span pairs = std::span(scene.pairs).first(count);
    const std::vector<Simplex> warm = run<float>(serial::gjk, placed, pairs).simplex;
    for (const std::vector<Simplex>& start : {cold, garbage, warm}) {
      const std::vector<Simplex> from(start.begin(), start.begin() + count);
      const Answer<float> expected = run<float>(serial::gjk, placed, pairs, from);
      for (const int threads : {1, 2, 3, 8}) {
        omp_set_num_threads(threads);
        const Answer<float> answer = run<float>(openmp::gjk, placed, pairs, from);
        for (std::size_t k = 0; k < count; ++k) {
          ASSERT_EQ(std::memcmp(&answer.closest[k], &expected.closest[k], sizeof(Closest<float>)), 0)
              << count << " pairs, " << threads << " threads, pair " << k << ": " << answer.closest[k].distance
              << " against " << expected.closest[k].distance;
          ASSERT_EQ(std::memcmp(&answer.simplex[k], &expected.simplex[k], sizeof(Simplex)), 0)
              << count << " pairs, pair " << k;
        }
      }
    }
  }
  omp_set_num_threads(threads_before);
}

}  // namespace
}  // namespace lockstep::rigid::gjk_pairs
