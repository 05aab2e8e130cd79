// The scaling model where threads wait: for locks, for flags, and until they go on. As in scale_test.cpp, it must give
// exactly the results of a calculation by hand.
#include <gtest/gtest.h>
#include <omp.h>

#include <array>
#include <vector>

#include "common/flags.h"
#include "tests/simulated_clock.h"
#include "verify/record.h"
#include "verify/replay.h"

namespace lockstep::verify {
namespace {

TEST(scale, all_under_one_lock) {
  omp_lock_t lock;
  omp_init_lock(&lock);
  const auto work = [&] {
#pragma omp parallel for schedule(static)
    for (int i = 0; i < 64; ++i) {
      omp_set_lock(&lock);
      spend(10);
      omp_unset_lock(&lock);
    }
  };
  for (const int cores : {1, 2, 16, 64}) EXPECT_EQ(modelled(cores, work), 640) << cores;
  Costs costs;
  costs.lock_moved = 4;
  EXPECT_EQ(modelled(1, work, costs), 640);
  EXPECT_EQ(modelled(64, work, costs), 640 + 63 * 4);
  omp_destroy_lock(&lock);
}

// Recording each lock takes time that a record without locks does not contain.
TEST(scale, a_record_that_notes_locks_is_fitted_to_one_that_does_not) {
  omp_lock_t lock;
  omp_init_lock(&lock);
  double under_lock = 30, beside = 15;
  const auto work = [&] {
    spend(100);
#pragma omp parallel for schedule(static)
    for (int i = 0; i < 64; ++i) {
      spend(beside);
      omp_set_lock(&lock);
      spend(under_lock);
      omp_unset_lock(&lock);
    }
  };
  Record noted = record(16, work, test_clock, 0, Waits::noted);
  EXPECT_TRUE(has_waits(noted));
  under_lock = 20, beside = 10;
  const Record whole = record(16, work, test_clock, 0, Waits::left_out);
  EXPECT_FALSE(has_waits(whole));
  fit(noted, whole);
  EXPECT_DOUBLE_EQ(replay(noted, free_of_charge, 0).total, 100 + 10 + 64 * 20);
  omp_destroy_lock(&lock);
}

// Clocks at locks may slow one member more than others.
TEST(scale, each_member_is_fitted_to_its_own_work) {
  omp_lock_t lock;
  omp_init_lock(&lock);
  double of_the_first = 30;
  const auto work = [&] {
#pragma omp parallel for schedule(static)
    for (int i = 0; i < 16; ++i) {
      spend(omp_get_thread_num() == 0 ? of_the_first : 10);
      omp_set_lock(&lock);
      omp_unset_lock(&lock);
    }
  };
  Record noted = record(16, work, test_clock, 0, Waits::noted);
  of_the_first = 10;
  fit(noted, record(16, work, test_clock, 0, Waits::left_out));
  EXPECT_DOUBLE_EQ(replay(noted, free_of_charge, 0).total, 10);
  omp_destroy_lock(&lock);
}

TEST(scale, locks_of_each_own_do_not_wait) {
  std::array<omp_lock_t, 8> locks;
  for (omp_lock_t& lock : locks) omp_init_lock(&lock);
  const auto work = [&] {
#pragma omp parallel
    {
      omp_lock_t* mine = &locks[omp_get_thread_num()];
      omp_set_lock(mine);
      spend(50);
      omp_unset_lock(mine);
    }
  };
  EXPECT_EQ(modelled(8, work), 50);
}

// Short waits are part of the cost of a barrier. After a longer one a core goes on late, and after a long one later.
// The core that wakes it is late, too.
TEST(scale, cores_that_waited_go_on_late) {
  Costs costs;
  costs.waking = {.from_yielding = 3, .falling_asleep = {10, 2}, .asleep = {20, 7}};
  double before = 0, first = 0, second = 0;  // ns: before the region; of its two cores, up to a barrier
  double behind = 100;                       // of the first core, behind the barrier; the second works for 100
  const auto work = [&] {
    spend(before);
#pragma omp parallel
    {
      spend(omp_get_thread_num() == 0 ? first : second);
#pragma omp barrier
      spend(omp_get_thread_num() == 0 ? behind : 100);
    }
  };
  const auto waits = [&](double ns_before, double ns_of_first, double ns_of_second) {
    before = ns_before, first = ns_of_first, second = ns_of_second;
    return modelled(2, work, costs);
  };
  EXPECT_EQ(waits(900, 10, 10), 900 + 10 + 100);
  // The second core begins late.
  EXPECT_EQ(waits(2000, 10, 10), 2000 + 3 + 10 + 100);
  EXPECT_EQ(waits(55'000, 10, 10), 55'000 + 10 + 10 + 100);
  EXPECT_EQ(waits(70'000, 10, 10), 70'000 + 20 + 10 + 100);
  // Waking it costs the first core time, which is then the later one.
  EXPECT_EQ(waits(55'000, 1000, 10), 55'000 + 2 + 1000 + 100);
  EXPECT_EQ(waits(70'000, 1000, 10), 70'000 + 7 + 1000 + 100);
  // One of them waits at the barrier, and the other has been waiting for it when the region ends.
  EXPECT_EQ(waits(0, 10, 5000), 5000 + 3 + 100);
  EXPECT_EQ(waits(0, 5000, 10), 5000 + 3 + 100);
  EXPECT_EQ(waits(0, 55'000, 10), 55'000 + 10 + 100);
  EXPECT_EQ(waits(0, 70'000, 10), 70'000 + 20 + 100);
  // At the barrier, too, the later core wakes the other one. Here it then works for longer.
  behind = 1000;
  EXPECT_EQ(waits(0, 55'000, 10), 55'000 + 2 + 1000);
  EXPECT_EQ(waits(0, 70'000, 10), 70'000 + 7 + 1000);
  behind = 100;
  before = 70'000;
  EXPECT_EQ(modelled(1, work, costs), 70'000 + 70'000 + 100);
}

// The first core wakes late from the end of a region, and the second from the wait for the next one.
TEST(scale, cores_wait_for_regions_to_end_and_to_begin) {
  Costs costs;
  costs.waking = {.from_yielding = 3, .falling_asleep = {10, 2}, .asleep = {20, 7}};
  const auto work = [] {
#pragma omp parallel
    spend(omp_get_thread_num() == 0 ? 10 : 5000);
    spend(800);
#pragma omp parallel
    spend(omp_get_thread_num() == 0 ? 5000 : 10);
    spend(800);
#pragma omp parallel
    spend(10);
  };
  EXPECT_EQ(modelled(2, work, costs), 5000 + 3 + 800 + 5000 + 800 + 3 + 10);
}

// One link a thread, each of which waits for the one before.
TEST(scale, chain_of_flags) {
  const auto work = [] {
    std::vector<Flag> flags(64);
#pragma omp parallel
    {
      const int thread = omp_get_thread_num();
      if (thread > 0) await(flags[thread - 1], 1);
      spend(100);
      post(flags[thread], 1);
    }
  };
  Costs costs;
  costs.flag = {.seen = 7, .read = 2};
  for (const int cores : {1, 2, 16, 64}) {
    EXPECT_EQ(modelled(cores, work), 100 * cores) << cores;
    EXPECT_EQ(modelled(cores, work, costs), 100 * cores + 7 * (cores - 1)) << cores;
  }
}

// Every thread goes through twelve windows, each of them after the thread before. The first one's take longer in the
// second half, so all others wait for it there.
TEST(scale, pipeline_of_slabs) {
  constexpr int windows = 12;
  double first = 10;
  const auto work = [&] {
    std::vector<Flag> flags(64);
#pragma omp parallel
    {
      const int thread = omp_get_thread_num();
      for (int w = 0; w < windows; ++w) {
        if (thread > 0) await(flags[thread - 1], w + 1);
        spend(thread == 0 ? first : 10);
        post(flags[thread], w + 1);
      }
    }
  };
  Costs costs;
  costs.flag = {.seen = 3, .read = 1};
  for (const int cores : {1, 2, 16, 64}) EXPECT_EQ(modelled(cores, work), 10 * (windows + cores - 1)) << cores;
  EXPECT_EQ(modelled(1, work, costs), 120);
  // The first window is seen 3 late. The others were posted before, and each thread falls behind by another 1 a window.
  EXPECT_EQ(modelled(2, work, costs), 10 + 13 + 11 * 11);
  EXPECT_EQ(modelled(64, work, costs), 10 + 62 * 13 + 13 + 11 * 11);
  first = 25;
  EXPECT_EQ(modelled(64, work, costs), 12 * 25 + 63 * 13);
  Record noted = record(64, work, test_clock, 0, Waits::noted);
  const Replayed r = replay(noted, costs, 0);
  EXPECT_EQ(r.work + r.serial + r.together + r.locks + r.dispatch + r.waiting, 64 * r.total);
  // A record without flags has the same work of each member, and says nothing of their order.
  first = 10;
  const Record whole = record(64, work, test_clock, 0, Waits::left_out);
  EXPECT_TRUE(has_waits(noted));
  EXPECT_FALSE(has_waits(whole));
  EXPECT_EQ(replay(whole, costs, 0).total, 120);
  fit(noted, whole);
  EXPECT_NEAR(replay(noted, costs, 0).total, 10 + 62 * 13 + 13 + 11 * 11, 1e-9);
}

}  // namespace
}  // namespace lockstep::verify
