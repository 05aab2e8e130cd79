// Shards of the program's commands are disjoint and together the whole; `lockstep merge` makes the whole report of
// theirs, and refuses what does not belong together.
#include "verify/shard.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/input_error.h"
#include "tests/cli.h"

namespace lockstep {
namespace {

using Json = nlohmann::ordered_json;
using verify::Shard;
using verify::shard_of;

TEST(Shard, SharesAreDisjointAndTogetherTheWhole) {
  for (const int of : {1, 2, 3, 7})
    for (std::size_t place = 0; place < 40; ++place) {
      int takers = 0;
      for (int number = 1; number <= of; ++number) takers += Shard{number, of}.has(place);
      EXPECT_EQ(takers, 1) << place << " of " << of;
    }
}

TEST(Shard, ReadsAndRefuses) {
  const Shard shard = shard_of("2/3");
  EXPECT_EQ(shard.number, 2);
  EXPECT_EQ(shard.of, 3);
  for (const char* text : {"0/2", "3/2", "a/b", "1", "1/", "/2", "-1/2", "1/2/3", "1/0", " 1/2", "1/ 2", "1.5/2",
                           "1/99999999999", "1/100001"})
    EXPECT_THROW(shard_of(text), InputError) << text;
}

// Without what is measured.
Json names_of(Json rows) {
  for (Json& row : rows)
    for (const char* field : {"serial_ms", "openmp_ms", "cores", "whole_cores", "ms", "least_ms", "spread", "lane_use",
                              "items_per_s", "seconds", "bytes", "bytes_left_over"})
      row.erase(field);
  return rows;
}

struct Shards : Cli {
  Json report(const std::string& name) const { return Json::parse(read_bytes(path(name))); }
  void write(const std::string& name, const Json& report) const { write_bytes(path(name), report.dump()); }

  // The names of the reports of all shards.
  std::vector<std::string> run_shards(const std::vector<std::string>& command, int of) const {
    std::vector<std::string> reports;
    for (int number = 1; number <= of; ++number) {
      std::vector<std::string> arguments = command;
      const std::string share = std::to_string(number) + '/' + std::to_string(of);
      reports.push_back(path(std::to_string(number) + "of" + std::to_string(of) + ".json"));
      arguments.insert(arguments.end(), {"--shard", share, "--json", reports.back()});
      const Outcome outcome = run(arguments);
      EXPECT_EQ(outcome.code, 0) << outcome.err;
    }
    return reports;
  }
  Outcome merge(std::vector<std::string> reports) const {
    reports.insert(reports.begin(), "merge");
    reports.insert(reports.end(), {"--out", path("merged.json")});
    return run(reports);
  }
  void expect_no_merge(std::vector<std::string> reports, const std::string& about) const {
    reports.insert(reports.begin(), "merge");
    reports.insert(reports.end(), {"--out", path("none.json")});
    expect_refused(reports, about);
  }

  void expect_the_whole(std::vector<std::string> command, const std::string& says) const {
    std::vector<std::string> arguments = command;
    arguments.insert(arguments.end(), {"--json", path("whole.json")});
    ASSERT_EQ(run(arguments).code, 0);
    const Json whole = report("whole.json");
    for (const int of : {1, 2, 3}) {
      SCOPED_TRACE(of);
      const std::vector<std::string> parts = run_shards(command, of);
      std::size_t rows = 0;
      for (const std::string& part : parts) rows += Json::parse(read_bytes(part))["rows"].size();
      EXPECT_EQ(rows, whole["rows"].size());
      const Outcome outcome = merge({parts.rbegin(), parts.rend()});
      EXPECT_EQ(outcome.code, 0) << outcome.err;
      EXPECT_TRUE(outcome.out.ends_with(says)) << outcome.out;
      const Json merged = report("merged.json");
      EXPECT_EQ(names_of(merged["rows"]), names_of(whole["rows"]));
      EXPECT_EQ(merged["command"], whole["command"]);
      EXPECT_EQ(merged["shards"].size(), std::size_t(of));
      EXPECT_FALSE(merged.contains("shard"));
    }
  }
};

TEST_F(Shards, OfVerifyAreTheWhole) {
  expect_the_whole({"verify", "--kernel", "linear/dot,linear/update", "--scene", "file_truss", "--threads", "1,2"},
                   "\n8 passed, 0 failed\n");
}
TEST_F(Shards, OfBenchAreTheWhole) {
  expect_the_whole({"bench", "--kernel", "cloth/verlet,cloth/relax", "--scene", "rope", "--threads", "1", "--quick"},
                   " rows\n");
}
TEST_F(Shards, OfFiguresAreTheWhole) {
  for (const std::string share : {"1/1", "1/2", "2/2"}) {
    const std::string out = path(std::string(1, share[0]) + "of" + share[2]);
    const Outcome outcome =
        run({"figures", "--report", "cloth_convergence", "--quick", "--shard", share, "--out", out});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
  }
  const auto name = [&](const std::string& share) { return path(share + "/cloth_convergence.json"); };
  ASSERT_EQ(merge({name("1of1")}).code, 0);
  const Json whole = report("merged.json")["rows"];
  EXPECT_EQ(whole.size(), 4u * 4 * 3);
  ASSERT_EQ(merge({name("2of2"), name("1of2")}).code, 0);
  EXPECT_EQ(report("merged.json")["rows"], whole);  // residuals, which no clock changes
}
TEST_F(Shards, OfEndureAreTheWhole) {
  const std::vector<std::string> parts = run_shards({"endure", "--scene", "rope", "--steps", "40"}, 2);
  EXPECT_EQ(Json::parse(read_bytes(parts[1]))["rows"].size(), 0u);
  const Outcome outcome = merge(parts);
  EXPECT_EQ(outcome.out, "1 passed, 0 refused, 0 failed\n");
}

TEST_F(Shards, BadOnesAreRefused) {
  for (const std::string command : {"verify", "bench", "scale"})
    for (const char* share : {"0/2", "3/2", "a/b"})
      expect_refused(
          {command, "--kernel", "cloth/verlet", "--scene", "rope", "--shard", share, "--json", path("a.json")},
          std::string("--shard ") + share + ": expected I/N with 1 <= I <= N");
  expect_refused({"endure", "--shard", "2"}, "expected I/N");
  expect_refused({"figures", "--out", path("a"), "--shard", "2"}, "expected I/N");
}

const std::vector<std::string> quick = {"verify",    "--kernel", "cloth/verlet,cloth/collide", "--scene", "rope",
                                        "--threads", "1"};

TEST_F(Shards, MergeFailsWhereARowFailed) {
  const std::vector<std::string> parts = run_shards(quick, 2);
  Json failed = Json::parse(read_bytes(parts[1]));
  failed["rows"][0]["passed"] = false;
  write_bytes(parts[1], failed.dump());
  const Outcome outcome = merge(parts);
  EXPECT_EQ(outcome.code, 1);
  EXPECT_TRUE(outcome.out.ends_with("\n1 passed, 1 failed\n")) << outcome.out;
  EXPECT_NE(outcome.out.find("FAILED"), std::string::npos) << outcome.out;
  EXPECT_TRUE(std::filesystem::exists(path("merged.json")));
}

TEST_F(Shards, MergeRefusesWhatDoesNotBelongTogether) {
  const std::vector<std::string> parts = run_shards(quick, 2), of_three = run_shards(quick, 3);
  const Json good = Json::parse(read_bytes(parts[1]));
  const auto expect = [&](const std::string& place, const Json& value, const std::string& about) {
    Json other = good;
    other[Json::json_pointer(place)] = value;
    write("other.json", other);
    expect_no_merge({parts[0], path("other.json")}, about);
  };
  for (const std::string field : {"commit", "isa", "flags", "compiler"})
    expect("/machine/" + field, "another", "other.json: its machine/" + field + " is \"another\", that of ");
  expect("/command", "verify --threads 1", "its command is \"verify --threads 1\"");
  expect("/schema", 0, "its schema is 0, expected 1");
  expect("/quick", true, "its quick is true");
  expect("/complete", false, "its run was cut off");
  expect("/rows/0/place", 0, "the place 0 of a row is not of its shard");
  expect("/shard/of", 3, "its shard/of is 3");
  expect("/shard/number", 3, "expected I/N");
  expect("/shard", "no shard", "is no report");
  expect_no_merge({parts[0]}, "missing shards: 2/2");
  expect_no_merge({of_three[1]}, "missing shards: 1/3, 3/3");
  expect_no_merge({parts[0], parts[1], parts[0]}, "both are shard 1");
  expect_no_merge({parts[0], path("nowhere.json")}, "nowhere.json: cannot be read");
  write_bytes(path("bad.json"), "{");
  expect_no_merge({parts[0], path("bad.json")}, "bad.json: is no report");
  ASSERT_EQ(merge(parts).code, 0);
  expect_no_merge({path("merged.json")}, "is not the report of a shard");
  expect_refused({"merge", parts[0], parts[1], "--out", path("none/x.json")}, "none/x.json");
}

// Verdicts hold on machines of several kinds; times do not compare.
TEST_F(Shards, MergeMixesMachinesForVerdictsAlone) {
  const std::vector<std::string> bench = {
      "bench", "--kernel", "cloth/verlet,cloth/collide", "--scene", "rope", "--threads", "1", "--quick"};
  for (const auto& command : {quick, bench}) {
    const std::vector<std::string> parts = run_shards(command, 2);
    Json other = Json::parse(read_bytes(parts[1]));
    other["machine"]["cpu"] = "another";
    write_bytes(parts[1], other.dump());
    if (command == bench) {
      expect_no_merge(parts, "its machine/cpu is \"another\"");
    } else {
      ASSERT_EQ(merge(parts).code, 0);
      EXPECT_EQ(report("merged.json")["shards"][1]["cpu"], "another");
    }
  }
}

// A shard goes on from its own rows, not from another's.
TEST_F(Shards, ResumeGoesOnWithTheSameShard) {
  std::vector<std::string> command = {"bench",   "--kernel",     "cloth/verlet,cloth/collide",
                                      "--scene", "rope",         "--threads",
                                      "1",       "--quick",      "--resume",
                                      "--json",  path("a.json"), "--shard",
                                      "1/2"};
  ASSERT_EQ(run(command).code, 0);
  const Json before = report("a.json");
  ASSERT_EQ(run(command).code, 0);
  EXPECT_EQ(report("a.json")["rows"], before["rows"]);
  command.back() = "2/2";
  expect_refused(command, "--resume mixes no reports: its shard is");
  command.back() = "1/2", command[2] = "cloth/verlet";
  expect_refused(command, "its command is");
}

}  // namespace
}  // namespace lockstep
