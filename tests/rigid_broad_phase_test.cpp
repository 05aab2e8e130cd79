// The broad phases against every pair tested, on small scenes of all sorts and on larger ones; boxes against the vertices they are to hold.
#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <numbers>
#include <random>

#include "common/rigid/broad_phase.h"
#include "common/rigid/make.h"
#include "common/rigid/scene.h"

namespace lockstep::rigid {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

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

void add(Boxes& scene, const Box<float>& box, std::int32_t group) {
  const int i = scene.bounds.count;
  scene.bounds.resize(i + 1);
  scene.bounds.set(i, box);
  scene.group.push_back(group);
}

// Every pair tested.
Pairs brute_force(const Boxes& scene) {
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
Boxes random_scene(Random& random, int count) {
  const int places = random.integer(0, 4), sizes = random.integer(0, 4);
  const float extent = std::exp(random.real(-1, 4)), offset = random.chance(.2f) ? random.real(-1000, 1000) : 0;
  const int per_body = random.chance(.3f) ? random.integer(2, 8) : 1;
  const float fixed = random.chance(.5f) ? 0 : random.real(0, 1), planes = random.chance(.7f) ? 0 : .1f;
  const auto position = [&]() -> float {
    switch (places) {
      case 0: return offset;                                                                         // all in one place
      case 1: return offset + static_cast<float>(random.integer(-5, 5));                             // on a lattice
      case 2: return offset + random.real(-1, 1) * random.real(-1, 1) * extent;                      // denser in the middle
      case 3: return random.chance(.05f) ? random.real(-1e6f, 1e6f) : random.real(-extent, extent);  // some far away
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
    const Vector3<float> low = {random.chance(.02f) ? -0.f : position(), position(), random.chance(.02f) ? 0.f : position()};
    add(scene, {low, {low.x + side(), low.y + side(), low.z + side()}}, group);
  }
  return scene;
}

// n boxes side by side in a cube and a little larger than their places, each of which overlaps its neighbours; shuffled.
Boxes pile(Random& random, int side) {
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
void move(Random& random, float most, Bounds<float>& bounds) {
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
bool same_bits(const Vectors<float>& a, const Vectors<float>& b, int n) {
  return same_bits(a.x, b.x, n) && same_bits(a.y, b.y, n) && same_bits(a.z, b.z, n);
}
bool same_bits(const Bounds<float>& a, const Bounds<float>& b) {
  return a.count == b.count && same_bits(a.low, b.low, a.count) && same_bits(a.high, b.high, a.count);
}
bool same_bits(const Tree<float>& a, const Tree<float>& b) {
  return a.order == b.order && a.first == b.first && same_bits(a.boxes, b.boxes);
}

// What the forms carry from scene to scene.
struct States {
  SweepOrder batch, incremental, parallel;
};

// All serial forms find `expected`. The tree comes back.
Tree<float> expect_serial_pairs(const Boxes& scene, const Pairs& expected, States& states) {
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
void expect_parallel_pairs(const Boxes& scene, const Pairs& expected, const Tree<float>& tree, States& states) {
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
void expect_pairs_in_double(const Boxes& scene, const Pairs& expected) {
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

constexpr int thread_counts[] = {1, 2, 3, 4, 8};

void expect_pairs_at_all_thread_counts(const Boxes& scene, const Pairs& expected) {
  States states;
  const Tree<float> tree = expect_serial_pairs(scene, expected, states);
  for (const int threads : thread_counts) {
    omp_set_num_threads(threads);
    expect_parallel_pairs(scene, expected, tree, states);
  }
}

class BroadPhase : public testing::Test {
 protected:
  ~BroadPhase() override { omp_set_num_threads(threads_); }

 private:
  int threads_ = omp_get_max_threads();
};

TEST_F(BroadPhase, FindsThePairsOfTenThousandSmallScenes) {
  Random random(1);
  States states;  // of another scene each time
  long found = 0;
  for (int k = 0; k < 10'000 && !HasFailure(); ++k) {
    SCOPED_TRACE(k);
    const Boxes scene = random_scene(random, k < 20 ? k : random.chance(.3f) ? random.integer(0, 200) : random.integer(0, 60));
    const Pairs expected = brute_force(scene);
    found += static_cast<long>(expected.size());
    const Tree<float> tree = expect_serial_pairs(scene, expected, states);
    omp_set_num_threads(thread_counts[k % 25 < 5 ? k % 25 : 0]);  // where threads outnumber cores, they take long
    expect_parallel_pairs(scene, expected, tree, states);
    if (k % 10 == 0) expect_pairs_in_double(scene, expected);
  }
  EXPECT_GT(found, 500'000);  // not empty scenes
}

TEST_F(BroadPhase, FindsThePairsOfLargerScenes) {
  Random random(2);
  std::vector<Boxes> scenes = {pile(random, 14)};
  for (int k = 0; k < 5; ++k) scenes.push_back(random_scene(random, 1500));
  // Coincident boxes, more than fit a part of the order; one that touches all; boxes in a row along the last axis.
  Boxes same, all, row;
  for (int i = 0; i < 600; ++i) add(same, {{1, 2, 3}, {2, 3, 4}}, i);
  for (int i = 0; i < 4000; ++i) add(all, {{i * 1.f, 0, 0}, {i + .5f, 1, 1}}, i);
  add(all, {{-10, -10, -10}, {5000, 1, 1}}, 4000);
  for (int i = 0; i < 4000; ++i) add(row, {{0, 0, (i * 997 % 4000) * 1.f}, {1, 1, (i * 997 % 4000) + 1.f}}, i);
  scenes.insert(scenes.end(), {same, all, row});
  for (const Boxes& scene : scenes) {
    SCOPED_TRACE(&scene - scenes.data());
    const Pairs expected = brute_force(scene);
    expect_pairs_at_all_thread_counts(scene, expected);
    expect_pairs_in_double(scene, expected);
  }
}

TEST_F(BroadPhase, FindsThePairsOfEveryScene) {
  for (const auto& file : std::filesystem::directory_iterator("scenes/rigid")) {
    if (file.path().extension() != ".toml") continue;
    SCOPED_TRACE(file.path());
    const World<float> world = load_scene(file.path()).world;
    Boxes scene;
    Array<Pose<float>> placed;
    serial::place_colliders(world, .01f, placed, scene.bounds);
    scene.group.assign(world.colliders.group.begin(), world.colliders.group.begin() + world.colliders.count);
    const Pairs expected = brute_force(scene);
    expect_pairs_at_all_thread_counts(scene, expected);
  }
}

TEST_F(BroadPhase, KeepsStateWhileBoxesMove) {
  Random random(3);
  for (const float step : {.01f, .3f, 20.f}) {
    SCOPED_TRACE(step);
    Boxes scene = pile(random, 9);
    add(scene, whole_space<float>, -1);
    SweepOrder order;
    Tree<float> tree, parallel;
    serial::bvh_build(scene.bounds, tree);
    openmp::bvh_build(scene.bounds, parallel);
    for (int k = 0; k < 10; ++k) {
      omp_set_num_threads(thread_counts[k % 5]);
      move(random, step, scene.bounds);
      const Pairs expected = brute_force(scene);
      Pairs pairs;
      serial::sweep_and_prune_incremental(scene.bounds, scene.group, order, pairs);
      EXPECT_EQ(pairs, expected);
      serial::bvh_refit(scene.bounds, tree);
      serial::bvh_pairs(tree, scene.bounds, scene.group, pairs);
      EXPECT_EQ(pairs, expected);
      openmp::bvh_refit(scene.bounds, parallel);
      EXPECT_TRUE(same_bits(tree, parallel));
      openmp::bvh_pairs(parallel, scene.bounds, scene.group, pairs);
      EXPECT_EQ(pairs, expected);
    }
  }
}

TEST_F(BroadPhase, MendsAnyOrder) {
  Random random(4);
  for (int k = 0; k < 200; ++k) {
    SCOPED_TRACE(k);
    const Boxes scene = random_scene(random, 50);
    SweepOrder state = {random.integer(0, 2), {}};
    for (int i = random.integer(0, 60); i > 0; --i) state.order.push_back(random.integer(-2, 60));
    if (random.chance(.5f)) {  // all of them, some way around
      state.order.clear();
      for (int i = 0; i < 50; ++i)
        if (scene.bounds.bounded(i)) state.order.push_back(i);
      std::shuffle(state.order.begin(), state.order.end(), std::mt19937(k));
    }
    Pairs pairs;
    serial::sweep_and_prune_incremental(scene.bounds, scene.group, state, pairs);
    EXPECT_EQ(pairs, brute_force(scene));
  }
}

TEST_F(BroadPhase, SweepsAlongTheAxisOfGreatestVariance) {
  for (int axis = 0; axis < 3; ++axis) {
    Boxes scene;
    for (int i = 0; i < 50; ++i) {
      float at[3] = {i % 5 * 1.f, i % 7 * 1.f, i % 3 * 1.f};
      at[axis] = i * 1.f;
      add(scene, {{at[0], at[1], at[2]}, {at[0], at[1], at[2]}}, i);
    }
    Pairs pairs;
    SweepOrder state, parallel;
    serial::sweep_and_prune_batch(scene.bounds, scene.group, state, pairs);
    openmp::sweep_and_prune_batch(scene.bounds, scene.group, parallel, pairs);
    EXPECT_EQ(state.axis, axis);
    EXPECT_EQ(parallel.axis, axis);
  }
}

// --- Colliders in the world

Quaternion<double> random_rotation(Random& random) {
  Quaternion<double> q;
  double length;
  do {
    q = {random.real(-1, 1), random.real(-1, 1), random.real(-1, 1), random.real(-1, 1)};
    length = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  } while (length < .1);
  return {q.x / length, q.y / length, q.z / length, q.w / length};
}

Pose<double> random_pose(Random& random, float extent) {
  return {{random.real(-extent, extent), random.real(-extent, extent), random.real(-extent, extent)}, random_rotation(random), 0};
}

// Colliders of all kinds, planes of which some are not level.
World<double> random_world(Random& random, int bodies, float extent, float planes) {
  World<double> world = make_world();
  std::vector<Vector3<double>> points;
  for (int k = 0; k < 30; ++k) points.push_back({random.real(0, 2), random.real(-1, 1), random.real(-3, 0)});  // not around its origin
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

Vector3<double> in_double(const Vector3<float>& v) { return {v.x, v.y, v.z}; }
Vector3<double> at(const Pose<double>& pose, const Vector3<double>& v) { return pose.position + matrix_of(pose.orientation) * v; }

TEST_F(BroadPhase, BoxesAreTheSmallestThatHoldTheirColliders) {
  Random random(5);
  for (const float margin : {0.f, .05f})
    for (const int bodies : {0, 1, 7, 300}) {
      const World<float> world = convert<float>(random_world(random, bodies, 50, .05f));
      const Colliders<float>& colliders = world.colliders;
      Array<Pose<float>> placed;
      Bounds<float> bounds;
      serial::place_colliders(world, margin, placed, bounds);
      ASSERT_EQ(bounds.count, colliders.count);
      for (int i = 0; i < colliders.count; ++i) {
        SCOPED_TRACE(i);
        EXPECT_EQ(bounds.bounded(i), colliders.kind[i] != static_cast<int>(Kind::plane));
        if (!bounds.bounded(i)) continue;

        // The float pose in double. With u = 2^-24, to first order: an element of its matrix, at most 1, is off by at most 5 u (squares by
        // u each, twice their sum, and the last difference), so a turned vector h by (5 + 1 + 2) u sum|h|, and by u sum|h| more as its
        // components are products. That holds for the middle and for the extent; radius and margin, then extent, middle and the ends are
        // each rounded once more, the ends of at most |p| + 2 s, where p is the position and s the sum of all that is added to it. The
        // hull's box and its vertices came from double and are off by u each: 2 u s. In total 2 u |p| + 18 u s; one more for the higher
        // orders.
        const Quad<float>&size = colliders.size[i], &centre = world.hulls.centre[colliders.hull[i]],
              &half = world.hulls.half[colliders.hull[i]];
        const Vector3<double> p = in_double(placed[i].position);
        const Quaternion<float>& q = placed[i].orientation;
        const Pose<double> pose = {p, {q.x, q.y, q.z, q.w}, 0};
        const double s = size.x * (std::abs(centre.x) + half.x) + size.y * (std::abs(centre.y) + half.y) +
                         size.z * (std::abs(centre.z) + half.z) + size.w + margin;
        const double u = std::ldexp(1., -24), widening = double(size.w) + margin;
        const auto bound = [&](double position) { return u * (2 * std::abs(position) + 19 * s); };
        const Box<float> box = bounds.box(i);

        Box<double> around_vertices = empty_box<double>;
        for (int k = world.hulls.first_vertex[colliders.hull[i]]; k < world.hulls.first_vertex[colliders.hull[i] + 1]; ++k) {
          const Quad<float>& vertex = world.hulls.vertex[k];
          const Vector3<double> v = at(pose, {double(size.x) * vertex.x, double(size.y) * vertex.y, double(size.z) * vertex.z});
          around_vertices = around(around_vertices, {v, v});
        }
        EXPECT_NEAR(box.low.x, around_vertices.low.x - widening, bound(p.x));
        EXPECT_NEAR(box.low.y, around_vertices.low.y - widening, bound(p.y));
        EXPECT_NEAR(box.low.z, around_vertices.low.z - widening, bound(p.z));
        EXPECT_NEAR(box.high.x, around_vertices.high.x + widening, bound(p.x));
        EXPECT_NEAR(box.high.y, around_vertices.high.y + widening, bound(p.y));
        EXPECT_NEAR(box.high.z, around_vertices.high.z + widening, bound(p.z));
      }

      for (const int threads : thread_counts) {
        omp_set_num_threads(threads);
        Array<Pose<float>> parallel_placed;
        Bounds<float> parallel;
        openmp::place_colliders(world, margin, parallel_placed, parallel);
        EXPECT_TRUE(same_bits(bounds, parallel));
        EXPECT_TRUE(same_bits(placed, parallel_placed, colliders.count));
      }
    }
}

TEST_F(BroadPhase, CollidersGoWhereTheirBodiesAre) {
  Random random(6);
  const World<double> world = random_world(random, 100, 50, 0);
  Array<Pose<double>> placed;
  Bounds<double> bounds;
  serial::place_colliders(world, 0, placed, bounds);
  for (int i = 0; i < world.colliders.count; ++i)
    for (const Vector3<double>& v : {Vector3<double>{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}) {
      const Vector3<double> expected = at(world.bodies.pose[world.colliders.body[i]], at(world.colliders.local[i], v));
      const Vector3<double> off = at(placed[i], v) - expected;
      // Lengths of at most 60, of some 30 roundings each.
      EXPECT_LT(std::sqrt(dot(off, off)), 30 * 60 * std::ldexp(1., -53));
    }
}

TEST_F(BroadPhase, PlanesMeetWhatReachesBelowThem) {
  Random random(7);
  long found = 0;
  for (int k = 0; k < 200; ++k) {
    SCOPED_TRACE(k);
    // Some with many colliders, so that strips are cut; planes before, between and after them.
    const World<float> world = convert<float>(random_world(random, k < 195 ? random.integer(0, 60) : 2000, 5, k % 5 * .1f));
    const Colliders<float>& colliders = world.colliders;
    Array<Pose<float>> placed;
    Bounds<float> bounds;
    serial::place_colliders(world, 0, placed, bounds);

    // Any of eight corners below the plane. Corners are as far from the plane as this text says, in the same order of operations.
    Pairs expected;
    const auto reaches_below = [&](int plane, int i) {
      const Vector3<float> normal = matrix_of(placed[plane].orientation).y, point = placed[plane].position;
      bool below = false;
      for (int corner = 0; corner < 8; ++corner) {
        const Box<float> box = bounds.box(i);
        const Vector3<float> v = {corner & 1 ? box.high.x : box.low.x, corner & 2 ? box.high.y : box.low.y,
                                  corner & 4 ? box.high.z : box.low.z};
        below |= dot(v - point, normal) <= 0;
      }
      return below;
    };
    for (int a = 0; a < colliders.count; ++a)
      for (int b = a + 1; b < colliders.count; ++b) {
        if (bounds.bounded(a) == bounds.bounded(b) || colliders.group[a] == colliders.group[b]) continue;
        if (bounds.bounded(a) ? reaches_below(b, a) : reaches_below(a, b)) expected.push_back({a, b});
      }
    found += static_cast<long>(expected.size());

    Pairs pairs = {{-1, -1}};
    serial::plane_pairs(colliders, placed, bounds, pairs);
    EXPECT_EQ(pairs, expected);
    omp_set_num_threads(thread_counts[k % 5]);
    openmp::plane_pairs(colliders, placed, bounds, pairs);
    EXPECT_EQ(pairs, expected);
  }
  EXPECT_GT(found, 10'000);
}

}  // namespace
}  // namespace lockstep::rigid
