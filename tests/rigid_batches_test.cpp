// Batches and levels of contacts against their definitions. tests/cloth_test.cpp tests first fit itself, and
// tests/batches_test.cpp its parallel form.
#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <random>
#include <set>
#include <vector>

#include "tests/contact_problems.h"

namespace lockstep::rigid::contacts {
namespace {

using Lists = std::vector<std::vector<std::int32_t>>;

Lists lists_of(const Batches& batches) {
  Lists lists;
  for (int k = 0; k < batches.count(); ++k)
    lists.emplace_back(batches.order.begin() + batches.begin[k], batches.order.begin() + batches.begin[k + 1]);
  return lists;
}

// C1 .. C4 are numbered 0 .. 3. The papers count the ground b4 as a body like others; the batches are the same if it is
// static.
TEST(ContactBatches, OfThePapersFourBodies) {
  const std::vector<std::int32_t> a = {0, 1, 2, 0}, b = {1, 2, 3, 3};
  const Lists expected = {{0, 2}, {1, 3}};
  EXPECT_EQ(lists_of(make_batches(a, b, std::vector<char>{1, 1, 1, 1})), expected);
  EXPECT_EQ(lists_of(make_batches(a, b, std::vector<char>{1, 1, 1, 0})), expected);
  const Problem<double> p = papers_bodies(0, {0, 0, 0});
  EXPECT_EQ(lists_of(serial::batches(p.manifolds, p.body, p.bodies)), expected);
  // In the original order C2 waits for C1, and C3 for C2. C4 waits for C1 and, if the ground counts, for C3.
  EXPECT_EQ(lists_of(make_levels(a, b, std::vector<char>{1, 1, 1, 1})), (Lists{{0}, {1}, {2}, {3}}));
  EXPECT_EQ(lists_of(make_levels(a, b, std::vector<char>{1, 1, 1, 0})), (Lists{{0}, {1, 3}, {2}}));
}

// Each contact once, no body that moves twice in a batch, at most `most(degree)` batches of bodies in `degree`
// contacts, and the same at every number of threads.
template <class Most>
void expect_batches(ReorderContacts<float>& serial, ReorderContacts<float>& parallel, Most most) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Problem<float> p = crowd(20 + 10 * seed, 300, .04 * seed, seed);
    const Batches batches = serial(p.manifolds, p.body, p.bodies);
    std::vector<int> degree(p.bodies.count), times(p.manifolds.size());
    for (const Manifold<float>& m : p.manifolds)
      for (const int body : {p.body[m.a], p.body[m.b]}) degree[body] += p.bodies.inverse_mass[body].w > 0;
    for (const std::vector<std::int32_t>& batch : lists_of(batches)) {
      EXPECT_TRUE(std::ranges::is_sorted(batch));
      std::set<int> seen;
      for (const std::int32_t k : batch) {
        ++times[k];
        for (const int body : {p.body[p.manifolds[k].a], p.body[p.manifolds[k].b]})
          EXPECT_TRUE(p.bodies.inverse_mass[body].w == 0 || seen.insert(body).second) << body;
      }
    }
    EXPECT_EQ(times, std::vector<int>(p.manifolds.size(), 1));
    EXPECT_LE(batches.count(), most(std::ranges::max(degree)));
    for (const int threads : thread_counts) {
      omp_set_num_threads(threads);
      const Batches openmp = parallel(p.manifolds, p.body, p.bodies);
      EXPECT_TRUE(openmp.order == batches.order && openmp.begin == batches.begin);
    }
  }
}

TEST(ContactBatches, AreAtMostTwiceTheDegreeAndHaveNoBodyTwice) {
  expect_batches(serial::batches, openmp::batches, [](int degree) { return 2 * degree - 1; });
}

TEST(FoldedLevels, AreAtMostARingOrTwiceTheDegreeAndHaveNoBodyTwice) {
  expect_batches(serial::batches_folded, openmp::batches_folded,
                 [](int degree) { return std::max(ring_batches, 2 * degree - 1); });
}

// The turns of a chain go round the ring, whichever batches are empty.
TEST(FoldedLevels, OfAChainGoRoundTheRing) {
  std::vector<std::int32_t> a, b;
  for (int k = 0; k < 3 * ring_batches + 1; ++k) a.push_back(k), b.push_back(k + 1);
  const Lists folded = lists_of(make_folded_levels(a, b, std::vector<char>(a.size() + 1, 1)));
  ASSERT_EQ(folded.size(), std::size_t(ring_batches));
  for (std::int32_t k = 0; k < static_cast<std::int32_t>(a.size()); ++k)
    EXPECT_EQ(std::ranges::count(folded[k % ring_batches], k), 1) << k;
}

// Where the levels are no more than the ring has batches, each is one.
TEST(FoldedLevels, AreLevelsWhileTheseAreFew) {
  EXPECT_EQ(make_folded_levels({}, {}, {}).count(), 0);
  std::mt19937 random(4);
  int graphs = 0;
  for (int graph = 0; graph < 200; ++graph) {
    const int objects = 40, constraints = random() % 60;
    std::vector<char> movable(objects);
    for (char& m : movable) m = random() % 10 != 0;
    std::vector<std::int32_t> a, b;
    for (int k = 0; k < constraints; ++k) {
      a.push_back(random() % objects);
      b.push_back((a.back() + 1 + random() % (objects - 1)) % objects);
    }
    const Batches levels = make_levels(a, b, movable);
    if (levels.count() > ring_batches) continue;
    ++graphs;
    EXPECT_EQ(lists_of(make_folded_levels(a, b, movable)), lists_of(levels));
  }
  EXPECT_GT(graphs, 100);
}

// A star's constraints share its centre: each is a batch of its own, also behind the ring and behind the first 64.
TEST(FoldedLevels, OfAStarAreAsManyAsItsConstraints) {
  for (const std::int32_t leaves : {ring_batches, ring_batches + 1, 64, 65, 200}) {
    std::vector<std::int32_t> a(leaves, 0), b;
    for (std::int32_t k = 1; k <= leaves; ++k) b.push_back(k);
    const Batches folded = make_folded_levels(a, b, std::vector<char>(leaves + 1, 1));
    EXPECT_EQ(folded.count(), leaves);
    EXPECT_TRUE(std::ranges::is_sorted(folded.order));
  }
}

TEST(ContactLevels, AreAsEarlyAsTheOrderLets) {
  EXPECT_EQ(make_levels({}, {}, {}).count(), 0);
  std::mt19937 random(3);
  for (int graph = 0; graph < 30; ++graph) {
    const int objects = 2 + random() % 100, constraints = random() % 400;
    std::vector<char> movable(objects);
    for (char& m : movable) m = random() % 10 != 0;
    std::vector<std::int32_t> a, b;
    for (int k = 0; k < constraints; ++k) {
      a.push_back(random() % objects);
      b.push_back((a.back() + 1 + random() % (objects - 1)) % objects);
    }
    const Lists levels = lists_of(make_levels(a, b, movable));
    std::vector<int> level_of(constraints, -1);
    for (std::size_t level = 0; level < levels.size(); ++level) {
      EXPECT_TRUE(std::ranges::is_sorted(levels[level]));
      for (const std::int32_t k : levels[level]) {
        EXPECT_EQ(level_of[k], -1);
        level_of[k] = static_cast<int>(level);
      }
    }
    for (int k = 0; k < constraints; ++k) {
      int last = -1;  // the last level that k waits for
      for (int l = 0; l < k; ++l)
        for (const int i : {a[l], b[l]})
          if (movable[i] && (i == a[k] || i == b[k])) last = std::max(last, level_of[l]);
      EXPECT_EQ(level_of[k], last + 1);
    }
  }
}

}  // namespace
}  // namespace lockstep::rigid::contacts
