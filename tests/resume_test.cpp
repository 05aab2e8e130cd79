// Reports that a run left when it was cut off: --resume goes on from their rows, and mixes no others.
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "tests/cli.h"

namespace lockstep {
namespace {

using Json = nlohmann::json;

// A row without what is measured.
Json name_of(const Json& row) {
  Json name;
  for (const char* field : {"kernel", "form", "scene", "variant", "threads", "cores", "iterations"})
    if (row.contains(field) && (std::string(field) != "cores" || !row.contains("threads"))) name[field] = row[field];
  return name;
}

struct Resume : Cli {
  Json report(const std::string& name) const { return Json::parse(read_bytes(path(name))); }

  // Removes a row in the middle of a report, runs the command again, and expects all rows once, the others unchanged.
  void expect_to_go_on(std::vector<std::string> command, const std::string& file) const {
    ASSERT_EQ(run(command).code, 0);
    const Json whole = report(file);
    Json cut = whole;
    const std::size_t middle = whole["rows"].size() / 2;
    cut["rows"].erase(middle);
    write_bytes(path(file), cut.dump());
    command.push_back("--resume");
    const Outcome outcome = run(command);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    const Json resumed = report(file);
    std::multiset<Json> names, expected;
    for (const Json& row : resumed["rows"]) names.insert(name_of(row));
    for (const Json& row : whole["rows"]) expected.insert(name_of(row));
    EXPECT_EQ(names, expected);
    EXPECT_EQ(std::set(names.begin(), names.end()).size(), names.size());
    std::size_t same = 0;
    for (const Json& row : cut["rows"]) same += std::ranges::count(resumed["rows"], row);
    EXPECT_GE(same + 2, cut["rows"].size());  // bench measures a case as a whole: serial and openmp
    EXPECT_LT(same, whole["rows"].size());
  }
};

TEST_F(Resume, BenchMeasuresWhatIsMissing) {
  expect_to_go_on({"bench", "--kernel", "cloth/verlet,cloth/collide,fluid/advance", "--threads", "1", "--quick",
                   "--scene", "rope", "--json", path("bench.json")},
                  "bench.json");
}

TEST_F(Resume, ScaleMeasuresWhatIsMissing) {
  expect_to_go_on({"scale", "--kernel", "cloth/verlet,cloth/collide", "--scene", "rope", "--cores", "1,2,8", "--quick",
                   "--json", path("scale.json")},
                  "scale.json");
}

// All rows but one are made up, so that a row that is measured shows.
TEST_F(Resume, FiguresMeasuresWhatIsMissing) {
  constexpr double made_up = 123;
  Json rows = Json::array();
  for (const char* scene : {"flag_33", "sheet_on_sphere", "rope", "pulled_edge"})
    for (const char* form : {"original", "chains", "colours", "batches"})
      for (const int iterations : {5, 20, 80})
        rows.push_back({{"scene", scene}, {"form", form}, {"iterations", iterations}, {"residual", made_up}});
  const std::size_t missing = rows.size() - 1;
  Json cut = {{"schema", 1}, {"quick", true}, {"brief", false}};
  cut["machine"] = Json::parse(run({"list", "--json"}).out)["machine"];
  cut["rows"] = rows;
  cut["rows"].erase(missing);
  write_bytes(path("cloth_convergence.json"), cut.dump());
  const Outcome outcome = run({"figures", "--report", "cloth_convergence", "--quick", "--resume", "--out", folder});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  std::multiset<Json> names, expected;
  for (const Json& row : rows) expected.insert(name_of(row));
  int measured = 0;
  const Json resumed = report("cloth_convergence.json");
  for (const Json& row : resumed["rows"]) {
    names.insert(name_of(row));
    measured += row["residual"] != made_up;
  }
  EXPECT_EQ(names, expected);
  EXPECT_EQ(measured, 1);
  expect_refused({"figures", "--report", "cloth", "--out", folder}, "some of: bench, scale, cloth_convergence");
}

// A benchmark is killed after its first rows; after how many, depends on how soon this test hears of them.
TEST_F(Resume, KeepsWhatItHadWhenItWasKilled) {
  std::vector<std::string> command = {"bench",   "--kernel", "cloth/verlet,cloth/relax,cloth/collide",
                                      "--scene", "rope",     "--threads",
                                      "1",       "--json",   path("bench.json")};
  const pid_t child = start(command);
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(120);
  while (!std::filesystem::exists(path("bench.json")) && std::chrono::steady_clock::now() < give_up)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  kill(child, SIGKILL);
  end_of(child);
  const Json before = report("bench.json")["rows"];
  command.push_back("--resume");
  ASSERT_EQ(run(command).code, 0);
  const Json after = report("bench.json")["rows"];
  ASSERT_GE(before.size(), 2u);
  ASSERT_LT(before.size(), after.size());
  for (std::size_t i = 0; i < before.size(); ++i) EXPECT_EQ(after[i], before[i]);
  EXPECT_NE(after.back()["kernel"], before[0]["kernel"]);
}

// Rows of kernels that the second run does not select stay.
TEST_F(Resume, LosesNoRows) {
  const auto bench = [&](const std::string& kernel) {
    const Outcome outcome = run({"bench", "--kernel", kernel, "--scene", "rope", "--threads", "1", "--quick",
                                 "--resume", "--json", path("bench.json")});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return report("bench.json")["rows"];
  };
  EXPECT_EQ(bench("cloth/verlet").size(), 2u);
  EXPECT_EQ(bench("cloth/collide").size(), 4u);
  EXPECT_EQ(bench("cloth/verlet").size(), 4u);
}

TEST_F(Resume, MixesNoReports) {
  const std::vector<std::string> command = {"bench",     "--kernel", "cloth/verlet", "--scene",          "rope",
                                            "--threads", "1",        "--json",       path("bench.json"), "--quick"};
  ASSERT_EQ(run(command).code, 0);
  std::vector<std::string> again = command;
  again.push_back("--resume");
  const Json good = report("bench.json");
  const auto expect = [&](const Json& other, const std::string& about) {
    write_bytes(path("bench.json"), other.dump());
    expect_refused(again, about);
    EXPECT_EQ(report("bench.json"), other);
  };
  for (const char* field : {"commit", "cpu", "isa", "flags", "omp"}) {
    Json other = good;
    other["machine"][field] = "another";
    expect(other, std::string("its ") + field + " is \"another\"");
  }
  Json other = good;
  other["quick"] = false;
  expect(other, "its quick is false");
  other = good;
  other["brief"] = true;
  expect(other, "its brief is true");
  other = good;
  other["schema"] = 0;
  expect(other, "its schema is 0");
  expect("no report", "mixes no reports");
  expect_refused({"bench", "--kernel", "cloth/verlet", "--resume"}, "--json");
}

}  // namespace
}  // namespace lockstep
