// The scaling model on OpenMP programs with known answers. They spend time on a simulated clock, so the model must give
// exactly the results of a calculation by hand.
#include <gtest/gtest.h>
#include <omp.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <numeric>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/simulated_clock.h"
#include "verify/record.h"
#include "verify/replay.h"

namespace lockstep::verify {
namespace {

TEST(scale, perfectly_parallel) {
  const auto work = [] {
#pragma omp parallel for schedule(static)
    for (int i = 0; i < 128; ++i) spend(10);
  };
  for (const int cores : {1, 2, 4, 8, 64}) EXPECT_EQ(modelled(cores, work), 1280 / cores) << cores;
}

TEST(scale, static_shares_end_with_the_largest) {
  const auto work = [] {
#pragma omp parallel for schedule(static)
    for (int i = 0; i < 65; ++i) spend(10);
  };
  EXPECT_EQ(modelled(64, work), 20);
}

TEST(scale, one_long_chunk) {
  const auto work = [] {
#pragma omp parallel for schedule(dynamic)
    for (int i = 0; i < 61; ++i) spend(i == 0 ? 1000 : 100);
  };
  EXPECT_EQ(modelled(1, work), 7000);
  EXPECT_EQ(modelled(2, work), 3500);  // 1000 + 25 x 100, and 35 x 100
  EXPECT_EQ(modelled(7, work), 1000);  // the other sixty are ten for each of six
  EXPECT_EQ(modelled(64, work), 1000);
}

TEST(scale, dynamic_chunks_of_four_go_to_whoever_is_free) {
  const auto work = [] {
#pragma omp parallel for schedule(dynamic, 4)
    for (unsigned long i = 0; i < 10; ++i) spend(10);
  };
  EXPECT_EQ(modelled(1, work), 100);
  EXPECT_EQ(modelled(2, work), 60);  // 4 + 2 and 4
  EXPECT_EQ(modelled(8, work), 40);
}

TEST(scale, chain) {
  const auto work = [] {
#pragma omp parallel
    for (int link = 0; link < 10; ++link) {
      if (omp_get_thread_num() == link % omp_get_num_threads()) spend(100);
#pragma omp barrier
    }
  };
  for (const int cores : {1, 2, 16, 64}) EXPECT_EQ(modelled(cores, work), 1000) << cores;
}

TEST(scale, memory_is_a_bound) {
  const auto work = [] {
#pragma omp parallel for schedule(static)
    for (int i = 0; i < 64; ++i) spend(100);
  };
  Costs costs;
  costs.bytes_per_ns = 10;
  EXPECT_EQ(modelled(1, work, costs, 20'000), 6400);
  EXPECT_EQ(modelled(2, work, costs, 20'000), 3200);
  EXPECT_EQ(modelled(4, work, costs, 20'000), 2000);
  EXPECT_EQ(modelled(64, work, costs, 20'000), 2000);
}

TEST(scale, serial_parts_and_what_forks_barriers_and_chunks_cost) {
  Costs costs;
  costs.fork_join = {7, 100};
  costs.barrier = {3, 20};
  costs.dispatch = {1, 4};
  const auto work = [] {
    spend(1000);
#pragma omp parallel
    {
      spend(10);
#pragma omp barrier
      spend(10);
    }
    spend(500);
  };
  EXPECT_EQ(modelled(1, work, costs), 1500 + 20 + 7 + 3);
  EXPECT_EQ(modelled(2, work, costs), 1500 + 20 + 100 + 20);
  EXPECT_EQ(modelled(16, work, costs), 1500 + 20 + 4 * 100 + 4 * 20);
  const Replayed r = replay(record(16, work, test_clock, 0, Waits::noted), costs, 0);
  EXPECT_EQ(r.work + r.serial + r.together + r.locks + r.dispatch + r.waiting, 16 * r.total);

  // One fetch at a time: eight threads fetch their first chunks one after another, and each fetches once more and gets
  // none.
  const auto loop = [] {
#pragma omp parallel for schedule(dynamic)
    for (int i = 0; i < 8; ++i) spend(1000);
  };
  EXPECT_EQ(modelled(8, loop, costs), 3 * 100 + 1 + 7 * 4 + 1000 + 4);
}

TEST(scale, sections_and_singles) {
  const auto sections = [] {
#pragma omp parallel sections
    {
#pragma omp section
      spend(100);
#pragma omp section
      spend(70);
    }
  };
  EXPECT_EQ(modelled(1, sections), 170);
  EXPECT_EQ(modelled(4, sections), 100);
  const auto singles = [] {
#pragma omp parallel
    {
#pragma omp single
      spend(30);
      spend(5);
#pragma omp single
      spend(30);
    }
  };
  EXPECT_EQ(modelled(4, singles), 65);
}

TEST(scale, a_region_in_a_region_has_one_thread) {
  std::array<int, 2> inner = {}, iterations = {};
  const auto work = [&] {
#pragma omp parallel
    {
      const int outer = omp_get_thread_num();
#pragma omp parallel for schedule(dynamic)
      for (int i = 0; i < 4; ++i) {
        spend(10);
        inner[outer] = omp_get_num_threads();
        ++iterations[outer];
      }
    }
  };
  EXPECT_EQ(modelled(2, work), 40);
  EXPECT_EQ(inner, (std::array{1, 1}));
  EXPECT_EQ(iterations, (std::array{4, 4}));
}

TEST(scale, what_is_computed_is_what_that_many_threads_compute) {
  std::vector<int> by(100, -1);
  int threads = 0;
  long sum = 0;
  record(
      64,
      [&] {
        threads = omp_get_max_threads();
#pragma omp parallel for schedule(static) reduction(+ : sum)
        for (int i = 0; i < 100; ++i) by[i] = omp_get_thread_num(), sum += i;
      },
      test_clock, 0, Waits::noted);
  EXPECT_EQ(threads, 64);
  EXPECT_EQ(sum, 4950);
  EXPECT_EQ(by.front(), 0);
  EXPECT_EQ(by.back(), 63);
  EXPECT_EQ(std::set(by.begin(), by.end()).size(), 64u);
}

// Of records of the same work, each of which was disturbed elsewhere.
TEST(scale, each_stretch_takes_the_least_of_its_times) {
  int disturbed = 0;
  const auto work = [&] {
    spend(disturbed == 0 ? 300 : 100);
#pragma omp parallel
    {
      spend(omp_get_thread_num() == disturbed ? 50 : 10);
#pragma omp for schedule(dynamic)
      for (int i = 0; i < 16; ++i) spend(i == 3 * disturbed ? 70 : 10);
    }
  };
  const auto modelled = [&](std::vector<int> disturbances) {
    Records records;
    for (const int thread : disturbances) {
      disturbed = thread;
      records.add(record(8, work, test_clock, 0, Waits::noted));
    }
    return replay(records.least(), free_of_charge, 0);
  };
  EXPECT_EQ(modelled({8}).total, 100 + 10 + 20);  // no thread and no chunk has this number
  EXPECT_EQ(modelled({0}).total, 300 + 10 + 70);
  EXPECT_EQ(modelled({1}).total, 100 + 10 + 70);
  // In all as much work as in the least disturbed record.
  const Replayed two = modelled({1, 2});
  EXPECT_DOUBLE_EQ(two.work, 100 + 8 * 10 + 40 + 16 * 10 + 60);
  EXPECT_DOUBLE_EQ(two.total, (100 + 10 + 20) * (two.work / (two.work - 100)));
  EXPECT_EQ(modelled({1, 2, 8}).total, 100 + 10 + 20);
}

// Threads that race divide their work as it comes. The least of each stretch would lack what another thread did.
TEST(scale, no_work_is_lost_that_another_thread_does) {
  int busy = 0;
  const auto work = [&] {
#pragma omp parallel
    spend(omp_get_thread_num() == busy ? 80 : 10);
  };
  Records records;
  for (busy = 0; busy < 8; ++busy) records.add(record(8, work, test_clock, 0, Waits::noted));
  EXPECT_DOUBLE_EQ(replay(records.least(), free_of_charge, 0).work, 80 + 7 * 10);
  // Where another thread executes a single, stretches are not compared.
  bool is_first_late = false;
  const auto single = [&] {
#pragma omp parallel
    {
#pragma omp for schedule(dynamic) nowait
      for (int i = 0; i < 2; ++i) spend(i == 1 ? 20 : is_first_late ? 30 : 10);
#pragma omp single nowait
      spend(80);
    }
  };
  Records singles;
  for (const bool is_late : {false, true}) {
    is_first_late = is_late;
    singles.add(record(2, single, test_clock, 0, Waits::noted));
  }
  EXPECT_DOUBLE_EQ(replay(singles.least(), free_of_charge, 0).total, 90);
}

// A call to the runtime that record_wraps.cpp does not wrap would go unseen by the model.
TEST(scale, every_call_to_the_runtime_is_known) {
  std::ifstream makefile("Makefile");
  std::stringstream text;
  text << makefile.rdbuf();
  std::smatch list;
  const std::string all = text.str();
  ASSERT_TRUE(std::regex_search(all, list, std::regex("WRAPPED = ((.*\\\\\n)*.*)\n")));
  std::stringstream words(std::regex_replace(list[1].str(), std::regex("\\\\"), " "));
  std::set<std::string> known = {"omp_init_lock",       "omp_destroy_lock",          "omp_get_num_procs",
                                 "omp_set_num_threads", "omp_set_max_active_levels", "omp_get_level",
                                 "GOMP_loop_start"};  // neither forks nor waits
  for (std::string word; words >> word;) known.insert(word);

  const char* program = std::getenv("LOCKSTEP");
  if (!program) GTEST_SKIP() << "LOCKSTEP does not name the program";
  FILE* symbols = popen((std::string("nm -D --undefined-only ") + program).c_str(), "r");
  ASSERT_NE(symbols, nullptr);
  char line[512];
  int found = 0;
  while (std::fgets(line, sizeof line, symbols)) {
    std::string name = line;
    name = name.substr(0, name.find_first_of("@\n"));
    name = name.substr(name.rfind(' ') + 1);
    if (!name.starts_with("GOMP_") && !name.starts_with("omp_")) continue;
    ++found;
    EXPECT_TRUE(known.contains(name)) << name;
  }
  pclose(symbols);
  EXPECT_GT(found, 10);
}

}  // namespace
}  // namespace lockstep::verify
