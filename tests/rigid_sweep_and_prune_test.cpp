// Sweep and prune: its axis, the order that it mends, and boxes without an upper end.
#include "tests/rigid_boxes.h"

namespace lockstep::rigid {
namespace {

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

// The padding behind the last box starts at infinity, where these end: a sweep that takes it for boxes runs off the
// arrays.
TEST_F(BroadPhase, BoxesMayEndAtInfinity) {
  Random random(8);
  for (int k = 0; k < 100; ++k) {
    SCOPED_TRACE(k);
    Boxes scene = random_scene(random, random.integer(1, 100));
    for (int i = 0; i < scene.bounds.count; ++i) {
      if (!scene.bounds.bounded(i) || !random.chance(.3f)) continue;
      Box<float> box = scene.bounds.box(i);
      const bool everywhere = random.chance(.5f);
      for (float* end : {&box.high.x, &box.high.y, &box.high.z})
        if (everywhere || random.chance(.5f)) *end = infinity;
      scene.bounds.set(i, box);
    }
    expect_pairs_at_all_thread_counts(scene, brute_force(scene));
  }
}

}  // namespace
}  // namespace lockstep::rigid
