// Contacts cut into blocks of space: what the solver relies on holds of any contacts.
#include "common/rigid/contact_blocks.h"

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <set>
#include <vector>

#include "tests/contact_problems.h"

namespace lockstep::rigid::contacts {
namespace {

// Each contact once; no body that moves in two blocks of a round, or twice in a group; a group of one to sixteen; one
// block in the last round that there may be.
template <class Real>
void expect_blocks(const Problem<Real>& p, const ContactBlocks& blocks) {
  std::vector<std::int32_t> all = blocks.order;
  std::ranges::sort(all);
  std::vector<std::int32_t> expected(p.manifolds.size());
  std::iota(expected.begin(), expected.end(), 0);
  ASSERT_EQ(all, expected);
  const auto ends_with = [](const std::vector<std::int32_t>& begins, std::size_t end) {
    return std::ranges::is_sorted(begins) && static_cast<std::size_t>(begins.back()) == end;
  };
  ASSERT_TRUE(ends_with(blocks.groups, all.size()));
  ASSERT_TRUE(ends_with(blocks.blocks, blocks.groups.size() - 1));
  ASSERT_TRUE(ends_with(blocks.rounds, blocks.blocks.size() - 1));
  const int rounds = static_cast<int>(blocks.rounds.size()) - 1;
  ASSERT_LE(rounds, most_rounds);
  for (int round = 0; round < rounds; ++round) {
    std::vector<int> block_of(p.bodies.count, -1);
    const int count = blocks.rounds[round + 1] - blocks.rounds[round];
    EXPECT_LE(count, most_blocks);
    if (round + 1 == most_rounds) {
      EXPECT_EQ(count, 1);
    }
    for (int block = blocks.rounds[round]; block < blocks.rounds[round + 1]; ++block)
      for (int group = blocks.blocks[block]; group < blocks.blocks[block + 1]; ++group) {
        std::set<std::int32_t> bodies;
        ASSERT_GE(blocks.groups[group + 1] - blocks.groups[group], 1);
        ASSERT_LE(blocks.groups[group + 1] - blocks.groups[group], group_size);
        for (int k = blocks.groups[group]; k < blocks.groups[group + 1]; ++k)
          for (const std::int32_t collider : {p.manifolds[blocks.order[k]].a, p.manifolds[blocks.order[k]].b}) {
            const std::int32_t i = p.body[collider];
            if (!(p.bodies.inverse_mass[i].w > 0)) continue;
            EXPECT_TRUE(bodies.insert(i).second) << "body " << i << " twice in group " << group;
            EXPECT_TRUE(block_of[i] < 0 || block_of[i] == block) << "body " << i << " in two blocks";
            block_of[i] = block;
          }
      }
  }
}

void expect_blocks_of_both(const Problem<float>& p) {
  ContactBlocks expected;
  serial::contact_blocks(p.manifolds, p.body, p.bodies, expected);
  expect_blocks(p, expected);
  ContactBlocks found;  // its memory is kept, so that what an earlier call left there would show
  for (const int threads : thread_counts) {
    omp_set_num_threads(threads);
    openmp::contact_blocks(p.manifolds, p.body, p.bodies, found);
    EXPECT_EQ(found.order, expected.order) << threads;
    EXPECT_EQ(found.groups, expected.groups) << threads;
    EXPECT_EQ(found.blocks, expected.blocks) << threads;
    EXPECT_EQ(found.rounds, expected.rounds) << threads;
  }
}

TEST(ContactBlocks, OfAnyNumberOfContacts) {
  unsigned seed = 1;
  for (const int contacts : {0, 1, 2, 15, 16, 17, 95, 96, 191, 192, 193, 1000, 7000})
    expect_blocks_of_both(crowd(2 + contacts, contacts, .2, seed++));
  expect_blocks_of_both(crowd(300, 5000, .9, seed++));
  expect_blocks_of_both(crowd(9000, 7000, 0, seed++));
}

// Neighbours in a lattice: nearly all contacts are within a block of the first round.
TEST(ContactBlocks, OfALatticeTakeMostContactsInTheFirstRound) {
  Problem<double> p;
  constexpr int n = 24;
  for (int i = 0; i < n * n * n; ++i)
    add(p, {.position = {double(i % n), double(i / n % n), double(i / n / n)}, .mass = 1});
  for (int i = 0; i < n * n * n; ++i) {
    if (i % n + 1 < n) touch(p, i, i + 1, {1, 0, 0}, {{{0, 0, 0}, 0}});
    if (i / n % n + 1 < n) touch(p, i, i + n, {0, 1, 0}, {{{0, 0, 0}, 0}});
    if (i / n / n + 1 < n) touch(p, i, i + n * n, {0, 0, 1}, {{{0, 0, 0}, 0}});
  }
  ContactBlocks blocks;
  serial::contact_blocks(p.manifolds, p.body, p.bodies, blocks);
  expect_blocks(p, blocks);
  ASSERT_EQ(blocks.rounds[1], most_blocks);
  // A block of 216 bodies, as a cube of six, has 3 * 6^2 of its 3 * 6^3 contacts across its lower borders: a sixth.
  // Pieces of the curve are less compact than cubes, so more may cross.
  const int within = blocks.groups[blocks.blocks[blocks.rounds[1]]];
  EXPECT_GT(within, .75 * static_cast<double>(p.manifolds.size()));
}

// A body that touches all others is in one block; what crosses to the others is left until the last round.
TEST(ContactBlocks, OfOneBodyThatAllOthersTouch) {
  Problem<float> p = crowd(3000, 3000, 0, 31);
  for (std::size_t k = 0; k < p.manifolds.size(); ++k)
    p.manifolds[k].a = 0, p.manifolds[k].b = 2 + static_cast<std::int32_t>(k % 2998);
  expect_blocks_of_both(p);
}

TEST(ContactBlocks, OfBodiesInOnePlaceAndFarAway) {
  Problem<float> p = crowd(3000, 4000, .1, 41);
  for (int i = 0; i < p.bodies.count; ++i)
    p.bodies.pose[i].position = i % 7 == 0 ? Vector3<float>{1e9f, -1e9f, 3} : Vector3<float>{1, 2, 3};
  expect_blocks_of_both(p);
  for (int i = 0; i < p.bodies.count; ++i) p.bodies.pose[i].position = {1, 2, 3};
  expect_blocks_of_both(p);
}

}  // namespace
}  // namespace lockstep::rigid::contacts
