// Batches chosen in parallel against those chosen in order, number by number, on graphs of all kinds. What first fit
// is, is tested in tests/cloth_test.cpp.
#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include "common/batches.h"
#include "openmp/batches.h"
#include "tests/temporary_folder.h"

namespace lockstep {
namespace {

struct Graph {
  std::vector<std::int32_t> a, b;
  std::vector<char> movable;

  explicit Graph(int objects) : movable(objects, true) {}
  int objects() const { return static_cast<int>(movable.size()); }
  void join(int i, int j) {
    if (i != j) a.push_back(i), b.push_back(j);
  }
};

// Places in every manner: all at one, along the numbers, and anywhere.
void expect_the_same(const Graph& graph, const char* what) {
  const Batches expected = make_batches(graph.a, graph.b, graph.movable);
  std::mt19937 random(1);
  std::vector<unsigned> anywhere(graph.movable.size());
  for (unsigned& place : anywhere) place = random();
  for (const int threads : {1, 2, 3, 4, 8}) {
    omp_set_num_threads(threads);
    const auto expect = [&](const Batches& found, const char* places) {
      EXPECT_EQ(found.begin, expected.begin) << what << ", " << places << ", threads " << threads;
      EXPECT_EQ(found.order, expected.order) << what << ", " << places << ", threads " << threads;
    };
    const auto with = [&](auto place) {
      return openmp::make_batches_in_parallel(graph.a, graph.b, graph.movable, place);
    };
    expect(with([](int) { return 0; }), "at one place");
    expect(with([](int i) { return i; }), "along the numbers");
    expect(with([&](int i) { return anywhere[i]; }), "anywhere");
  }
}

TEST(ParallelBatches, OfNothing) {
  expect_the_same(Graph(0), "no objects");
  expect_the_same(Graph(5), "no constraints");
}

TEST(ParallelBatches, OfFewConstraints) {
  std::mt19937 random(2);
  for (const int constraints : {1, 2, 15, 16, 17, 33, 100}) {
    Graph graph(2 + constraints / 2);
    while (static_cast<int>(graph.a.size()) < constraints)
      graph.join(random() % graph.objects(), random() % graph.objects());
    expect_the_same(graph, "few");
  }
}

TEST(ParallelBatches, OfRandomGraphs) {
  std::mt19937 random(3);
  for (const double immovable : {0., .3, 1.}) {
    Graph graph(2000);
    for (char& m : graph.movable) m = random() >= immovable * 0x1p32;
    for (int k = 0; k < 10000; ++k) graph.join(random() % graph.objects(), random() % graph.objects());
    expect_the_same(graph, "random");
  }
}

// Degrees by a power law: object i is drawn with a density of i^-1/2. Some are in hundreds of constraints, most in a
// few.
TEST(ParallelBatches, OfAPowerLaw) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> uniform(0, 1);
  Graph graph(3000);
  const auto drawn = [&] { return static_cast<int>(graph.objects() * std::pow(uniform(random), 2)); };
  for (int i = 0; i < graph.objects(); i += 11) graph.movable[i] = false;
  for (int k = 0; k < 12000; ++k) graph.join(drawn(), drawn());
  expect_the_same(graph, "power law");
}

// As many batches as constraints: up to what an object keeps bits for, and beyond.
TEST(ParallelBatches, OfStars) {
  for (const int leaves : {3, 63, 64, 65, 447, 448, 449, 1000}) {
    Graph graph(leaves + 1);
    for (int leaf = 0; leaf < leaves; ++leaf) graph.join(leaf % 2 ? leaf : leaves, leaf % 2 ? leaves : leaf);
    expect_the_same(graph, "star");
    EXPECT_EQ(make_batches(graph.a, graph.b, graph.movable).count(), leaves);
    graph.movable[leaves] = false;
    expect_the_same(graph, "star around what does not move");
  }
}

// Every object's batches as a set, and the rule word for word.
Batches first_fit(const Graph& graph) {
  std::vector<std::set<int>> taken(graph.movable.size());
  std::vector<std::vector<std::int32_t>> batches;
  for (std::size_t k = 0; k < graph.a.size(); ++k) {
    const auto in_use = [&](std::int32_t i, int batch) { return graph.movable[i] && taken[i].contains(batch); };
    int batch = 0;
    while (in_use(graph.a[k], batch) || in_use(graph.b[k], batch)) ++batch;
    taken[graph.a[k]].insert(batch), taken[graph.b[k]].insert(batch);
    batches.resize(std::max<std::size_t>(batches.size(), batch + 1));
    batches[batch].push_back(static_cast<std::int32_t>(k));
  }
  Batches result{{}, {0}};
  for (const std::vector<std::int32_t>& batch : batches) {
    result.order.insert(result.order.end(), batch.begin(), batch.end());
    result.begin.push_back(static_cast<std::int32_t>(result.order.size()));
  }
  return result;
}

// More than 64 batches: complete graphs in any order, with parallel edges to a few, and with objects that do not move.
TEST(Batches, BeyondTheFirst64AreFirstFit) {
  std::mt19937 random(6);
  for (const double immovable : {0., .3}) {
    Graph graph(150);
    for (char& m : graph.movable) m = random() >= immovable * 0x1p32;
    std::vector<std::pair<int, int>> edges;
    for (int i = 0; i < 150; ++i)
      for (int j = 0; j < i; ++j) edges.insert(edges.end(), i < 5 ? 100 : 1, {i, j});
    std::ranges::shuffle(edges, random);
    for (const auto& [i, j] : edges) graph.join(i, j);
    const Batches expected = first_fit(graph), found = make_batches(graph.a, graph.b, graph.movable);
    EXPECT_GT(expected.count(), 128);
    EXPECT_EQ(found.begin, expected.begin);
    EXPECT_EQ(found.order, expected.order);
  }
}

// The hub is in as many batches as there are leaves. A bit for each batch and object would be 1.25 GB.
TEST(Batches, OfALargeStarTakeMemoryByTheConstraint) {
  if (keeps_freed_memory) GTEST_SKIP() << "needs memory that is free again";
  constexpr int leaves = 100'000;
  Graph graph(leaves + 1);
  for (int leaf = 0; leaf < leaves; ++leaf) graph.join(leaf, leaves);
  const Limit limit(RLIMIT_AS, address_space() + 32'000'000);
  const Batches batches = make_batches(graph.a, graph.b, graph.movable);
  EXPECT_EQ(batches.count(), leaves);
  for (int leaf = 0; leaf < leaves; ++leaf) ASSERT_EQ(batches.order[leaf], leaf);
}

// Every constraint waits for the one before it, and thread for thread.
TEST(ParallelBatches, OfChains) {
  Graph there(5000), back(5000), shuffled(5000);
  std::vector<int> order(4999);
  for (int i = 0; i < 4999; ++i) {
    there.join(i, i + 1), back.join(5000 - i - 1, 5000 - i - 2);
    order[i] = i;
  }
  std::shuffle(order.begin(), order.end(), std::mt19937(5));
  for (const int i : order) shuffled.join(i, i + 1);
  expect_the_same(there, "chain");
  expect_the_same(back, "chain backwards");
  expect_the_same(shuffled, "chain in any order");
}

// Eight million objects: 512 MB for what is known of them, and 268 MB for what eight threads count.
TEST(ParallelBatches, ThrowWhereMemoryEnds) {
  const auto run = [](const Graph& graph) {
    openmp::make_batches_in_parallel(graph.a, graph.b, graph.movable, [](int i) { return i; });
  };
  omp_set_num_threads(8);
  Graph graph(1 << 23);
  graph.join(0, 1);
  run(Graph(16));  // starts the threads
  const Limit limit(RLIMIT_AS, address_space() + 620'000'000);
  EXPECT_THROW(run(graph), std::bad_alloc);
}

TEST(ParallelBatches, OfConstraintsBetweenTheSameTwo) {
  Graph graph(40);
  for (int k = 0; k < 1500; ++k) graph.join(k % 20, 20 + k % 20), graph.join(20 + k % 20, k % 20);
  expect_the_same(graph, "the same two");
}

}  // namespace
}  // namespace lockstep
