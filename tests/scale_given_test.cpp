// The fields of modelled rows, and the scaling model with costs of another machine.
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/cli.h"
#include "verify/scale.h"

namespace lockstep {
namespace {

using Json = nlohmann::json;
using verify::Model;

const Model ours = {{.fork_join = {100, 800},
                     .barrier = {50, 300},
                     .waking = {},
                     .lock_moved = 20,
                     .dispatch = {5, 40},
                     .flag = {},
                     .bytes_per_ns = 30},
                    /*last_level_cache_bytes=*/1e6,
                    /*clock_cost_ns=*/10,
                    /*turns_per_ns=*/1};

TEST(ScaleGiven, ReplacesWhatIsNamedAndNothingElse) {
  const auto before = verify::describe(ours);
  EXPECT_FALSE(verify::with_given(ours, {}).of_another);
  for (const std::string name : {"fork_join_2_ns", "barrier_2_ns", "lock_moved_ns", "dispatch_moved_ns",
                                 "memory_gb_per_s", "last_level_cache_bytes"}) {
    const Model another = verify::with_given(ours, {{name, 1234.5}});
    EXPECT_TRUE(another.of_another);
    auto expected = before;
    ASSERT_TRUE(expected.contains(name));
    expected[name] = 1234.5;
    EXPECT_EQ(verify::describe(another), expected);
  }
}

// The memory's time is that of the bytes beyond the cache of 1 MB, at the memory's rate.
TEST(ScaleGiven, BoundsTheRowByTheMemoryGiven) {
  const verify::Replayed replayed = {.total = 2e6, .compute = 2e6};
  const verify::Repeatable what = {{}, {}, 3e6};
  const auto memory_ms = [&](const std::map<std::string, double>& given) {
    return verify::fields_of(replayed, what, 2, verify::with_given(ours, given))["memory_ms"].get<double>();
  };
  EXPECT_DOUBLE_EQ(memory_ms({}), 2e6 / 30e9 * 1e3);
  EXPECT_DOUBLE_EQ(memory_ms({{"memory_gb_per_s", 300}}), 2e6 / 300e9 * 1e3);
  EXPECT_EQ(memory_ms({{"last_level_cache_bytes", 4e6}}), 0);
}

// Iterations find in the cache the share of their data that it has room for.
TEST(ScaleGiven, MemoryIsReadAnewWhereTheCacheHasNoRoomForAnIteration) {
  const auto memory_ms = [](double data) {
    return verify::fields_of({}, {{}, {}, 3e6, data}, 2, ours)["memory_ms"].get<double>();
  };
  EXPECT_DOUBLE_EQ(memory_ms(1.5e6), 3e6 / 3 / 30e9 * 1e3);  // the cache has 1 MB: a third of each iteration
  EXPECT_EQ(memory_ms(1e6), 0);
}

// Not 0 / 0, which JSON writes as null.
TEST(ScaleFields, AreNumbersWhereNothingTakesTime) {
  const auto fields = verify::fields_of({}, {}, 2, ours);
  EXPECT_EQ(fields.size(), 9u);
  for (const auto& [name, value] : fields.items()) EXPECT_EQ(value.get<double>(), 0) << name;
}

TEST_F(Cli, ScaleTakesAnotherMachine) {
  const std::vector<std::string> command = {"scale",   "--kernel", "cloth/verlet", "--scene", "rope",
                                            "--cores", "1,2,64",   "--quick",      "--json",  path("scale.json")};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), command.begin(), command.end());
    return more;
  };
  const auto report = [&] { return Json::parse(read_bytes(path("scale.json"))); };
  ASSERT_EQ(run(command).code, 0);
  EXPECT_EQ(report()["machine"]["given"], Json::object());
  EXPECT_TRUE(report()["rows"][0].contains("measured_ms"));

  // A fork and join of a second on two cores: 64 pay for six of them.
  ASSERT_EQ(run(with({"--fork-join-us", "1e6"})).code, 0);
  EXPECT_EQ(report()["machine"]["given"], Json({{"fork_join_2_ns", 1e9}}));
  EXPECT_EQ(report()["machine"]["costs"]["fork_join_2_ns"], 1e9);
  const Json rows = report()["rows"];
  EXPECT_LT(rows[0]["modelled_ms"].get<double>(), 1000);
  EXPECT_GE(rows[2]["modelled_ms"].get<double>(), 6000);
  for (const Json& row : rows) EXPECT_FALSE(row.contains("measured_ms") || row.contains("off_by")) << row;

  expect_refused(with({"--resume"}), "its given is");
  expect_refused(with({"--resume", "--fork-join-us", "2"}), "its given is");
  for (const char* option : {"--barrier-us", "--lock-us", "--dispatch-us", "--memory-gb-per-s"})
    for (const char* value : {"0", "-1", "nan", "inf"})
      expect_refused(with({option, value}), std::string(option) + ": expected a number above 0");
}

}  // namespace
}  // namespace lockstep
