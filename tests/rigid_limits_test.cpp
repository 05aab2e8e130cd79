// Crowds: pairs are quadratic in the bodies of one place. What does not fit the memory is refused in words, also within
// parallel regions.
#include "common/rigid/limits.h"

#include <omp.h>
#include <sys/resource.h>

#include <functional>
#include <limits>

#include "common/input_error.h"
#include "common/memory.h"
#include "openmp/spatial/pair_list.h"
#include "tests/cli.h"
#include "tests/rigid_boxes.h"

namespace lockstep::rigid {
namespace {

Boxes crowd(int n) {
  Boxes scene;
  scene.bounds.resize(n);
  for (int i = 0; i < n; ++i) {
    scene.bounds.set(i, {{0, 0, 0}, {1, 1, 1}});
    scene.group.push_back(i);
  }
  return scene;
}

std::string refusal_of(const std::function<void()>& find) {
  try {
    find();
  } catch (const InputError& error) {
    return error.what();
  } catch (const std::bad_alloc&) {
    return "out of memory";
  }
  return "";
}

// What each form says of a scene.
std::vector<std::string> refusals(const Boxes& scene) {
  std::vector<std::string> said;
  const auto add = [&](const auto& find) {
    Pairs pairs;
    said.push_back(refusal_of([&] { find(pairs); }));
  };
  SweepOrder state;
  Tree<float> tree;
  serial::bvh_build(scene.bounds, tree);
  add([&](Pairs& pairs) { serial::sweep_and_prune_batch(scene.bounds, scene.group, state, pairs); });
  add([&](Pairs& pairs) { serial::sweep_and_prune_incremental(scene.bounds, scene.group, state, pairs); });
  add([&](Pairs& pairs) { serial::bvh_pairs(tree, scene.bounds, scene.group, pairs); });
  add([&](Pairs& pairs) { serial::grid(scene.bounds, scene.group, pairs); });
  add([&](Pairs& pairs) { openmp::sweep_and_prune_batch(scene.bounds, scene.group, state, pairs); });
  add([&](Pairs& pairs) { openmp::bvh_pairs(tree, scene.bounds, scene.group, pairs); });
  add([&](Pairs& pairs) { openmp::grid(scene.bounds, scene.group, pairs); });
  return said;
}

struct MemoryLimit {
  explicit MemoryLimit(double bytes) { limit_memory(bytes); }
  ~MemoryLimit() { limit_memory(std::numeric_limits<double>::infinity()); }
};

TEST(RigidLimits, ContactsOfACrowdAreAskedForBeforeTheyAreMade) {
  const Boxes scene = crowd(700);  // 244,650 pairs
  const MemoryLimit limit(.9 * bytes_per_pair() * 244'650);
  for (const std::string& said : refusals(scene)) {
    EXPECT_EQ(said.rfind("a crowd of 244650 pairs of colliders whose boxes overlap needs ", 0), 0u) << said;
    EXPECT_EQ(said.find('\n'), std::string::npos) << said;
  }
}

TEST(RigidLimits, ACrowdThatFitsIsNotRefused) {
  const MemoryLimit limit(1.1 * bytes_per_pair() * 244'650);
  for (const std::string& said : refusals(crowd(700))) EXPECT_EQ(said, "");
}

// Lists of pairs are made within parallel regions, which no exception may leave.
TEST(RigidLimits, ListsOfACrowdAreRefused) {
  const Boxes scene = crowd(3000);  // 4,498,500 pairs, lists of 36 MB at the least
  const MemoryLimit limit(1.2e7);
  const int before = omp_get_max_threads();
  omp_set_num_threads(2);  // lists of many threads would each be small enough not to ask
  for (const std::string& said : refusals(scene)) EXPECT_EQ(said.rfind("room for ", 0), 0u) << said;
  omp_set_num_threads(before);
}

TEST(RigidLimits, PairsAreCountedBeyondInt) {
  std::vector<spatial::openmp::PairList> lists(3);
  for (auto& list : lists) list.count = 1'500'000'000;
  EXPECT_EQ(spatial::openmp::count_pairs(lists), 4.5e9);
  EXPECT_EQ(refusal_of([] { spatial::require_pairs_fit(4.5e9, 0); }),
            "room for 4500000000 pairs of boxes that overlap: expected at most 1073741824");
}

struct RigidCrowd : Cli {};

TEST_F(RigidCrowd, IsRefusedInOneLine) {
  if (keeps_freed_memory) GTEST_SKIP() << "needs a limit of the address space, of which the sanitizer takes 16 TB";
  std::string text = "kind = \"rigid\"\nframes = 1\n";
  for (int i = 0; i < 6000; ++i) text += "[[body]]\nsphere = 0.5\nmass = 1\n";
  const std::string spheres = scene(text);
  for (const char* variant : {"serial", "openmp"}) {
    const std::vector<std::string> run = {"run", "--scene", spheres, "--variant", variant, "--out", path("frames")};
    const Outcome outcome = end_of(start(run, [] {
      const rlimit limit = {500'000 * 1024, 500'000 * 1024};
      setrlimit(RLIMIT_AS, &limit);
    }));
    EXPECT_EQ(outcome.code, 2) << outcome.err;
    EXPECT_EQ(outcome.error_lines(), 1) << outcome.err;
  }
}

}  // namespace
}  // namespace lockstep::rigid
