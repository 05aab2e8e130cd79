// Boxes to try broad phases on: scenes of all sorts, every pair of them tested, and worlds of colliders of all kinds.
#pragma once

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "common/rigid/broad_phase.h"
#include "common/rigid/make.h"

namespace lockstep::rigid {

inline constexpr int thread_counts[] = {1, 2, 3, 4, 8};

inline constexpr float infinity = std::numeric_limits<float>::infinity();

struct Boxes {
  Bounds<float> bounds;
  std::vector<std::int32_t> group;
};

template <class To>
Bounds<To> bounds_in(const Bounds<float>& bounds) {
  Bounds<To> result;
  result.resize(bounds.count);
  for (int i = 0; i < bounds.count; ++i) {
    const Box<float> box = bounds.box(i);
    result.set(i, {{box.low.x, box.low.y, box.low.z}, {box.high.x, box.high.y, box.high.z}});
  }
  return result;
}

inline void add(Boxes& scene, const Box<float>& box, std::int32_t group) {
  const int i = scene.bounds.count;
  scene.bounds.resize(i + 1);
  scene.bounds.set(i, box);
  scene.group.push_back(group);
}

// Every pair tested.
inline Pairs brute_force(const Boxes& scene) {
  const Vectors<float>&low = scene.bounds.low, &high = scene.bounds.high;
  Pairs pairs;
  for (int a = 0; a < scene.bounds.count; ++a)
    for (int b = a + 1; b < scene.bounds.count; ++b) {
      if (low.x[a] == -infinity || low.x[b] == -infinity || scene.group[a] == scene.group[b]) continue;
      if (low.x[a] > high.x[b] || low.x[b] > high.x[a] || low.y[a] > high.y[b]) continue;
      if (low.y[b] > high.y[a] || low.z[a] > high.z[b] || low.z[b] > high.z[a]) continue;
      pairs.push_back({a, b});
    }
  return pairs;
}

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  float real(float low, float high) { return std::uniform_real_distribution<float>(low, high)(engine_); }
  int integer(int low, int high) { return std::uniform_int_distribution<int>(low, high)(engine_); }
  bool chance(float of) { return real(0, 1) < of; }

 private:
  std::mt19937 engine_;
};

// Boxes of one sort: where they are, how large, whose, all drawn.
inline Boxes random_scene(Random& random, int count) {
  const int places = random.integer(0, 4), sizes = random.integer(0, 4);
  const float extent = std::exp(random.real(-1, 4)), offset = random.chance(.2f) ? random.real(-1000, 1000) : 0;
  const int per_body = random.chance(.3f) ? random.integer(2, 8) : 1;
  const float fixed = random.chance(.5f) ? 0 : random.real(0, 1), planes = random.chance(.7f) ? 0 : .1f;
  const auto position = [&]() -> float {
    switch (places) {
      case 0: return offset;                                                     // all in one place
      case 1: return offset + static_cast<float>(random.integer(-5, 5));         // on a lattice
      case 2: return offset + random.real(-1, 1) * random.real(-1, 1) * extent;  // denser in the middle
      case 3: return random.chance(.05f) ? random.real(-1e6f, 1e6f) : random.real(-extent, extent);  // some far
      default: return offset + random.real(-extent, extent);
    }
  };
  const auto side = [&]() -> float {
    switch (sizes) {
      case 0: return 0;
      case 1: return 1;                             // on a lattice, these touch exactly
      case 2: return std::exp(random.real(-5, 3));  // of all sizes
      case 3: return random.chance(.02f) ? 10 * extent : random.real(.5f, 1.5f);
      default: return random.real(.5f, 1.5f);
    }
  };
  Boxes scene;
  for (int i = 0; i < count; ++i) {
    const std::int32_t group = random.chance(fixed) ? -1 : i / per_body;
    if (random.chance(planes)) {
      add(scene, whole_space<float>, -1);
      continue;
    }
    // Zero of either sign.
    const Vector3<float> low = {random.chance(.02f) ? -0.f : position(), position(),
                                random.chance(.02f) ? 0.f : position()};
    add(scene, {low, {low.x + side(), low.y + side(), low.z + side()}}, group);
  }
  return scene;
}

// n boxes side by side in a cube and a little larger than their places, each of which overlaps its neighbours;
// shuffled.
inline Boxes pile(Random& random, int side) {
  std::vector<Box<float>> boxes;
  for (int x = 0; x < side; ++x)
    for (int y = 0; y < side; ++y)
      for (int z = 0; z < side; ++z) {
        const Vector3<float> low = {x + random.real(-.1f, .1f), y + random.real(-.1f, .1f), z + random.real(-.1f, .1f)};
        boxes.push_back({low, {low.x + 1.05f, low.y + 1.05f, low.z + 1.05f}});
      }
  std::shuffle(boxes.begin(), boxes.end(), std::mt19937(7));
  Boxes scene;
  for (const Box<float>& box : boxes) add(scene, box, scene.bounds.count);
  return scene;
}

// Somewhere else, not far.
inline void move(Random& random, float most, Bounds<float>& bounds) {
  for (int i = 0; i < bounds.count; ++i) {
    if (!bounds.bounded(i)) continue;
    const Vector3<float> by = {random.real(-most, most), random.real(-most, most), random.real(-most, most)};
    const Box<float> box = bounds.box(i);
    bounds.set(i, {box.low + by, box.high + by});
  }
}

template <class T>
bool same_bits(const T& a, const T& b, int n) {
  return n == 0 || std::memcmp(a.data(), b.data(), n * sizeof(a[0])) == 0;
}
inline bool same_bits(const Vectors<float>& a, const Vectors<float>& b, int n) {
  return same_bits(a.x, b.x, n) && same_bits(a.y, b.y, n) && same_bits(a.z, b.z, n);
}
inline bool same_bits(const Bounds<float>& a, const Bounds<float>& b) {
  return a.count == b.count && same_bits(a.low, b.low, a.count) && same_bits(a.high, b.high, a.count);
}
inline bool same_bits(const Tree<float>& a, const Tree<float>& b) {
  return a.order == b.order && a.first == b.first && same_bits(a.boxes, b.boxes);
}

// What the forms carry from scene to scene.
struct States {
  SweepOrder batch, incremental, parallel;
};

// All serial forms find `expected`. The tree comes back.
inline Tree<float> expect_serial_pairs(const Boxes& scene, const Pairs& expected, States& states) {
  Pairs pairs = {{-1, -1}};
  serial::sweep_and_prune_batch(scene.bounds, scene.group, states.batch, pairs);
  EXPECT_EQ(pairs, expected);
  serial::sweep_and_prune_incremental(scene.bounds, scene.group, states.incremental, pairs);
  EXPECT_EQ(pairs, expected);
  EXPECT_EQ(states.incremental.order, states.batch.order);
  Tree<float> tree;
  serial::bvh_build(scene.bounds, tree);
  serial::bvh_pairs(tree, scene.bounds, scene.group, pairs);
  EXPECT_EQ(pairs, expected);
  serial::grid(scene.bounds, scene.group, pairs);
  EXPECT_EQ(pairs, expected);
  return tree;
}

// So do all of openmp/, and leave what serial/ left.
inline void expect_parallel_pairs(const Boxes& scene, const Pairs& expected, const Tree<float>& tree, States& states) {
  Pairs pairs = {{-1, -1}};
  openmp::sweep_and_prune_batch(scene.bounds, scene.group, states.parallel, pairs);
  EXPECT_EQ(pairs, expected);
  EXPECT_EQ(states.parallel.axis, states.batch.axis);
  EXPECT_EQ(states.parallel.order, states.batch.order);
  Tree<float> parallel;
  openmp::bvh_build(scene.bounds, parallel);
  EXPECT_TRUE(same_bits(tree, parallel));
  openmp::bvh_pairs(parallel, scene.bounds, scene.group, pairs);
  EXPECT_EQ(pairs, expected);
  openmp::grid(scene.bounds, scene.group, pairs);
  EXPECT_EQ(pairs, expected);
}

// The same of the double forms. Floats are doubles, so the pairs are the same.
inline void expect_pairs_in_double(const Boxes& scene, const Pairs& expected) {
  const Bounds<double> bounds = bounds_in<double>(scene.bounds);
  Pairs pairs;
  SweepOrder state;
  serial::sweep_and_prune_batch(bounds, scene.group, state, pairs);
  EXPECT_EQ(pairs, expected);
  serial::sweep_and_prune_incremental(bounds, scene.group, state, pairs);
  EXPECT_EQ(pairs, expected);
  Tree<double> tree;
  serial::bvh_build(bounds, tree);
  serial::bvh_pairs(tree, bounds, scene.group, pairs);
  EXPECT_EQ(pairs, expected);
  serial::grid(bounds, scene.group, pairs);
  EXPECT_EQ(pairs, expected);
}

inline void expect_pairs_at_all_thread_counts(const Boxes& scene, const Pairs& expected) {
  States states;
  const Tree<float> tree = expect_serial_pairs(scene, expected, states);
  for (const int threads : thread_counts) {
    omp_set_num_threads(threads);
    expect_parallel_pairs(scene, expected, tree, states);
  }
}

// Puts the number of threads back.
class BroadPhase : public testing::Test {
 protected:
  ~BroadPhase() override { omp_set_num_threads(threads_); }

 private:
  int threads_ = omp_get_max_threads();
};

inline Quaternion<double> random_rotation(Random& random) {
  Quaternion<double> q;
  double length;
  do {
    q = {random.real(-1, 1), random.real(-1, 1), random.real(-1, 1), random.real(-1, 1)};
    length = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  } while (length < .1);
  return {q.x / length, q.y / length, q.z / length, q.w / length};
}

inline Pose<double> random_pose(Random& random, float extent) {
  const auto coordinate = [&] { return random.real(-extent, extent); };
  return {{coordinate(), coordinate(), coordinate()}, random_rotation(random), 0};
}

// Colliders of all kinds, planes of which some are not level.
inline World<double> random_world(Random& random, int bodies, float extent, float planes) {
  World<double> world = make_world();
  std::vector<Vector3<double>> points;
  // Not around its origin.
  for (int k = 0; k < 30; ++k) points.push_back({random.real(0, 2), random.real(-1, 1), random.real(-3, 0)});
  const int hull = make_hull(world.hulls, points);
  for (int k = 0; k < bodies; ++k) {
    begin_body(world, random_pose(random, extent));
    if (random.chance(planes)) {
      add_plane(world, random.chance(.5f) ? no_offset : random_pose(random, 1));
      finish_body(world, immovable);
      continue;
    }
    for (int c = random.integer(1, 3); c > 0; --c) {
      const Pose<double> local = random_pose(random, 1);
      switch (random.integer(0, 3)) {
        case 0: add_sphere(world, random.real(.1f, 2), local); break;
        case 1: add_capsule(world, random.real(.1f, 2), random.real(.1f, 1), local); break;
        case 2: add_box(world, {random.real(.1f, 1), random.real(.1f, 2), random.real(.1f, 3)}, local); break;
        default: add_hull(world, hull, local);
      }
    }
    finish_body(world, random.chance(.2f) ? immovable : of_density(1));
  }
  return world;
}

}  // namespace lockstep::rigid
