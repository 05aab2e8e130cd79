// The tree, built and fitted, while boxes move.
#include "tests/rigid_boxes.h"

namespace lockstep::rigid {
namespace {

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

}  // namespace
}  // namespace lockstep::rigid
