// The narrow phase against its kernels called pair by pair: the same manifolds in the order of the pairs, at every
// thread count, and where GJK ended carried from step to step.
#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <random>

#include "common/rigid/narrow_phase.h"
#include "tests/rigid_shapes.h"

namespace lockstep::rigid {
namespace {

// A heap of shapes of all kinds on some planes, and every pair of two that are near, in order.
struct Heap {
  Shapes shapes;
  Pairs pairs;
};
Heap make_heap(int count, std::uint32_t seed) {
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  Heap heap;
  Shapes& shapes = heap.shapes;
  const std::vector<Vector3<double>> tetrahedron = {{.5, .5, .5}, {.5, -.5, -.5}, {-.5, .5, -.5}, {-.5, -.5, .5}};
  World<double> ground = make_world();
  begin_body(ground, no_offset);
  add_mesh(ground, {{{-.5, 0, -.5}, {.5, 0, -.5}, {0, 0, .5}}, {{0, 2, 1}}});
  shapes.hulls = ground.hulls;
  const int triangle = ground.colliders.hull[0], hull = make_hull(shapes.hulls, tetrahedron);
  const double side = std::cbrt(count) * .6;
  for (int k = 0; k < count; ++k) {
    const Pose<double> pose =
        at({uniform(0, side), uniform(-.1, side), uniform(0, side)}, k % 4 ? any_turn(random) : no_rotation);
    const int kind = random() % 16;
    if (kind < 4) shapes.sphere(uniform(.2, .5), pose);
    if (kind >= 4 && kind < 8) shapes.capsule(uniform(.1, .4), uniform(.1, .3), pose);
    if (kind >= 8 && kind < 12) shapes.box({uniform(.1, .5), uniform(.1, .5), uniform(.1, .5)}, pose);
    if (kind >= 12 && kind < 14) shapes.hull(hull, pose);
    if (kind == 14) shapes.add(Kind::triangle, triangle, {1, 1, 1, 0}, pose);
    if (kind == 15) shapes.plane(at({0, 0, 0}));
  }
  const auto is_plane = [&](int k) { return static_cast<Kind>(shapes.colliders.kind[k]) == Kind::plane; };
  for (int a = 0; a < count; ++a)
    for (int b = a + 1; b < count; ++b) {
      if (is_plane(a) && is_plane(b)) continue;
      const Vector3<double> d = shapes.pose[b].position - shapes.pose[a].position;
      if (is_plane(a) || is_plane(b) ? shapes.pose[is_plane(a) ? b : a].position.y < 1 : dot(d, d) < 1)
        heap.pairs.push_back({a, b});
    }
  return heap;
}

using Ended = std::map<Pair, Simplex>;

// One pair after another; which kernel takes which kinds is written out.
Array<Manifold<float>> pair_by_pair(const Placed<float>& placed, const Pairs& pairs, float margin, Ended& ended) {
  Array<Manifold<float>> manifolds;
  const Ended last = std::exchange(ended, {});
  for (const Pair& pair : pairs) {
    const Kind a = static_cast<Kind>(placed.colliders.kind[pair.a]),
               b = static_cast<Kind>(placed.colliders.kind[pair.b]);
    const auto either = [&](Kind kind) { return a == kind || b == kind; };
    const std::span<const Pair> one(&pair, 1);
    std::vector<Manifold<float>> manifold(1);
    if (either(Kind::plane)) {
      serial::planes(placed, one, margin, manifold);
    } else if (either(Kind::hull) || either(Kind::triangle)) {
      const auto found = last.find(pair);
      std::vector<Simplex> simplex(1);
      if (found != last.end()) simplex[0] = found->second;
      std::vector<Closest<float>> closest(1);
      std::vector<SeparatingAxis<float>> axis(1);
      serial::gjk(placed, one, simplex, closest);
      serial::convex_axes(placed, one, simplex, closest, margin, axis);
      serial::convex_clip(placed, one, axis, margin, manifold);
      ended[pair] = simplex[0];
    } else if (a == Kind::box && b == Kind::box) {
      serial::box_box(placed, one, margin, manifold);
    } else {
      serial::spheres(placed, one, margin, manifold);
    }
    if (manifold[0].count > 0) manifolds.push_back(manifold[0]);
  }
  return manifolds;
}

void expect_same(const Array<Manifold<float>>& a, const Array<Manifold<float>>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    ASSERT_EQ(a[k].a, b[k].a) << k;
    ASSERT_EQ(a[k].b, b[k].b) << k;
    ASSERT_EQ(std::memcmp(&a[k], &b[k], sizeof a[k]), 0) << k;
  }
}
void expect_same(const NarrowPhaseState& a, const NarrowPhaseState& b) {
  ASSERT_EQ(a.pairs, b.pairs);
  ASSERT_EQ(a.simplex.size(), b.simplex.size());
  for (std::size_t k = 0; k < a.simplex.size(); ++k)
    ASSERT_EQ(std::memcmp(&a.simplex[k], &b.simplex[k], sizeof(Simplex)), 0) << k;
}

// The heap, shaken by up to so many metres at every step; other pairs every step.
template <class Run>
void every_step(Heap heap, double shake, Run run) {
  std::mt19937 random(9);
  for (int step = 0; step < 3; ++step) {
    Pairs pairs;
    for (const Pair& pair : heap.pairs)
      if (random() % 5 != 0) pairs.push_back(pair);
    const Rounded<float> rounded(heap.shapes);
    run(rounded.placed(), pairs);
    for (Pose<double>& pose : heap.shapes.pose)
      pose.position.x += std::uniform_real_distribution<double>(-shake, shake)(random);
  }
}

TEST(RigidNarrowPhase, IsEveryPairByItsKernelInOrder) {
  const Heap heap = make_heap(400, 1);
  ASSERT_GT(heap.pairs.size(), 500u);
  Ended ended;
  NarrowPhaseState state;
  every_step(heap, .01, [&](const Placed<float>& placed, const Pairs& pairs) {
    Array<Manifold<float>> manifolds(3);  // to be forgotten
    serial::narrow_phase(placed, pairs, .02f, state, manifolds);
    expect_same(manifolds, pair_by_pair(placed, pairs, .02f, ended));
    EXPECT_TRUE(std::is_sorted(manifolds.begin(), manifolds.end(), [](const auto& m, const auto& n) {
      return Pair{m.a, m.b} < Pair{n.a, n.b};
    }));
    ASSERT_EQ(state.pairs.size(), ended.size());
    for (std::size_t k = 0; k < state.pairs.size(); ++k)
      EXPECT_EQ(std::memcmp(&state.simplex[k], &ended.at(state.pairs[k]), sizeof(Simplex)), 0);
    EXPECT_TRUE(std::any_of(state.simplex.begin(), state.simplex.end(), [](const Simplex& s) { return s.count > 0; }));
  });
}

TEST(RigidNarrowPhase, IsBitwiseTheSameInParallel) {
  const int before = omp_get_max_threads();
  for (const int count : {0, 1, 2, 20, 400}) {
    const Heap heap = make_heap(count, 2);
    for (const int threads : {1, 2, 3, 8}) {
      omp_set_num_threads(threads);
      NarrowPhaseState state, state_openmp;
      Array<Manifold<float>> manifolds, manifolds_openmp;
      every_step(heap, .01, [&](const Placed<float>& placed, const Pairs& pairs) {
        serial::narrow_phase(placed, pairs, .02f, state, manifolds);
        openmp::narrow_phase(placed, pairs, .02f, state_openmp, manifolds_openmp);
        expect_same(manifolds_openmp, manifolds);
        expect_same(state_openmp, state);
      });
      // Some pairs are kept, others move too far, are new or were left out in the step before.
      KeptContacts<float> kept, kept_openmp;
      every_step(heap, .0006, [&](const Placed<float>& placed, const Pairs& pairs) {
        serial::narrow_phase_kept(placed, pairs, .02f, state, kept, manifolds);
        openmp::narrow_phase_kept(placed, pairs, .02f, state_openmp, kept_openmp, manifolds_openmp);
        expect_same(manifolds_openmp, manifolds);
        expect_same(state_openmp, state);
        ASSERT_EQ(kept_openmp.pairs, kept.pairs);
        for (std::size_t k = 0; k < kept.contact.size(); ++k)
          ASSERT_EQ(std::memcmp(&kept_openmp.contact[k], &kept.contact[k], sizeof kept.contact[k]), 0) << k;
      });
      if (HasFatalFailure()) return;
    }
  }
  omp_set_num_threads(before);
}

// The number of pairs that each thread gets is none, some or many; pairs of all kinds, or of one alone.
TEST(RigidNarrowPhase, IsBitwiseTheSameForFewPairs) {
  const int before = omp_get_max_threads();
  const Heap heap = make_heap(400, 3);
  const Rounded<float> rounded(heap.shapes);
  for (const std::size_t count :
       {std::size_t(0), std::size_t(1), std::size_t(15), std::size_t(16), std::size_t(17), std::size_t(100)})
    for (const int threads : {1, 2, 3, 8}) {
      omp_set_num_threads(threads);
      const std::span<const Pair> some(heap.pairs.data(), count);
      NarrowPhaseState state, state_openmp;
      Array<Manifold<float>> manifolds, manifolds_openmp;
      serial::narrow_phase(rounded.placed(), some, 1.f, state, manifolds);
      openmp::narrow_phase(rounded.placed(), some, 1.f, state_openmp, manifolds_openmp);
      expect_same(manifolds_openmp, manifolds);
      expect_same(state_openmp, state);
    }
  omp_set_num_threads(before);
}

}  // namespace
}  // namespace lockstep::rigid
