// The broad phases against every pair tested, on small scenes of all sorts and on larger ones.
#include <filesystem>

#include "common/rigid/scene.h"
#include "tests/rigid_boxes.h"

namespace lockstep::rigid {
namespace {

TEST_F(BroadPhase, FindsThePairsOfTenThousandSmallScenes) {
  Random random(1);
  States states;  // of another scene each time
  long found = 0;
  for (int k = 0; k < 10'000 && !HasFailure(); ++k) {
    SCOPED_TRACE(k);
    const Boxes scene = random_scene(random, k < 20               ? k
                                             : random.chance(.3f) ? random.integer(0, 200)
                                                                  : random.integer(0, 60));
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

}  // namespace
}  // namespace lockstep::rigid
