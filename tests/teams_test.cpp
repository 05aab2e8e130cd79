// Teams of threads that are smaller than asked for: rows say so, or are left out.
#include <omp.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/cli.h"
#include "verify/team.h"

namespace lockstep {
namespace {

struct Teams : Cli {
  Outcome run_limited(const std::vector<std::string>& arguments) const {
    return end_of(start(arguments, [] { setenv("OMP_THREAD_LIMIT", "1", 1); }));
  }
};

TEST_F(Teams, VerifyFailsRowsThatRanOnFewerThreads) {
  const Outcome outcome =
      run_limited({"verify", "--kernel", "fluid/advance", "--scene", "scenes/fluid/single.toml", "--threads", "1,2"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_NE(outcome.out.find("ran on 1 thread, not 2"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("1 passed, 1 failed"), std::string::npos) << outcome.out;
}

TEST_F(Teams, BenchLeavesRowsOut) {
  const Outcome outcome = run_limited({"bench", "--kernel", "fluid/advance", "--scene", "scenes/fluid/single.toml",
                                       "--threads", "1,2", "--quick", "--json", path("bench.json")});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_NE(outcome.err.find("ran on 1 thread, not 2"), std::string::npos) << outcome.err;
  const nlohmann::json report = nlohmann::json::parse(read_bytes(path("bench.json")));
  EXPECT_EQ(report["rows"].size(), 2);  // serial and openmp
  for (const auto& row : report["rows"]) EXPECT_EQ(row["threads"], 1);
}

TEST(TeamSizes, DoubleUpToAllCores) {
  EXPECT_EQ(verify::doubling_to(1), std::vector<int>{1});
  EXPECT_EQ(verify::doubling_to(2), (std::vector<int>{1, 2}));
  EXPECT_EQ(verify::doubling_to(6), (std::vector<int>{1, 2, 4, 6}));
  EXPECT_EQ(verify::doubling_to(64), (std::vector<int>{1, 2, 4, 8, 16, 32, 64}));
}

TEST_F(Teams, BenchTakesAllCoresByDefault) {
  const std::vector<int> all = verify::doubling_to(omp_get_num_procs());
  for (const bool by_name : {false, true}) {
    std::vector<std::string> arguments = {"bench",  "--kernel", "fluid/advance", "--scene",
                                          "single", "--quick",  "--json",        path("bench.json")};
    if (by_name) arguments.insert(arguments.end(), {"--threads", "all"});
    ASSERT_EQ(run(arguments).code, 0);
    std::vector<int> threads;
    const nlohmann::json report = nlohmann::json::parse(read_bytes(path("bench.json")));
    for (const auto& row : report["rows"])
      if (row["variant"] == "openmp") threads.push_back(row["threads"]);
    EXPECT_EQ(threads, all);
  }
}

TEST_F(Teams, RunSaysIt) {
  const Outcome outcome = run_limited(
      {"run", "--scene", "scenes/cloth/rope.toml", "--frames", "2", "--threads", "2", "--out", path("frames")});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_NE(outcome.err.find("ran on 1 thread, not 2"), std::string::npos) << outcome.err;
}

}  // namespace
}  // namespace lockstep
