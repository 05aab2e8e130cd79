// `lockstep verify` and `bench` from the command line: exit codes, and reports that parse and hold every field.
#include <gtest/gtest.h>
#include <signal.h>

#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "tests/cli.h"

namespace lockstep {
namespace {

void expect_fields(const nlohmann::json& object, const std::vector<std::string>& fields) {
  for (const std::string& field : fields) EXPECT_TRUE(object.contains(field)) << field;
}

void expect_machine(const nlohmann::json& report) {
  ASSERT_TRUE(report.contains("machine") && report.contains("rows"));
  expect_fields(report["machine"], {"cpu", "cores", "isa", "lanes", "compiler", "flags", "commit", "omp"});
  EXPECT_EQ(report["machine"]["lanes"], 16);
}

TEST_F(Cli, VerifiesAndReports) {
  const std::string json = path("verify.json");
  const Outcome outcome =
      run({"verify", "--kernel", "fluid/advance", "--scene", "single", "--threads", "1,2", "--json", json});
  EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
  EXPECT_EQ(outcome.err, "");
  EXPECT_NE(outcome.out.find("2 passed, 0 failed\n"), std::string::npos) << outcome.out;
  const auto report = nlohmann::json::parse(read_bytes(json));
  expect_machine(report);
  ASSERT_EQ(report["rows"].size(), 2u);
  for (const auto& row : report["rows"]) {
    expect_fields(row, {"kernel", "form", "scene", "threads", "lanes", "verdict", "error", "bound", "worst_at",
                        "serial_ms", "openmp_ms", "passed"});
    EXPECT_EQ(row["kernel"], "fluid/advance");
    EXPECT_EQ(row["scene"], "single");
    EXPECT_EQ(row["verdict"], "bitwise");
    EXPECT_EQ(row["passed"], true);
  }
  EXPECT_EQ(report["rows"][1]["threads"], 2);
}

// A table of kernels ends the rows; with --failed only failures are printed.
TEST_F(Cli, SumsUpByKernel) {
  const std::vector<std::string> some = {"verify",    "--kernel", "fluid/advance,fluid/densities", "--scene", "single",
                                         "--threads", "1,2"};
  const Outcome all = run(some);
  EXPECT_EQ(all.code, 0);
  const std::size_t table = all.out.find("error/bound");
  ASSERT_NE(table, std::string::npos) << all.out;
  EXPECT_TRUE(std::regex_search(all.out.substr(table), std::regex("\nfluid/advance +2 +0 +- +2 bitwise\n"))) << all.out;
  EXPECT_TRUE(std::regex_search(all.out.substr(table), std::regex("\nfluid/densities +[0-9]+ +0 "))) << all.out;
  std::vector<std::string> quiet = some;
  quiet.push_back("--failed");
  EXPECT_TRUE(std::regex_match(run(quiet).out, std::regex("[0-9]+ passed, 0 failed\n")));

  const std::string wrong = scene(good_scene + "[holds]\nmomentum_conserved = true\n");
  const Outcome failed =
      run({"verify", "--kernel", "fluid/step,fluid/advance", "--scene", wrong, "--threads", "1", "--failed"});
  EXPECT_EQ(failed.code, 1);
  EXPECT_EQ(failed.out.find("fluid/advance"), std::string::npos) << failed.out;
  EXPECT_NE(failed.out.find("FAILED"), std::string::npos) << failed.out;
  EXPECT_TRUE(std::regex_search(failed.out, std::regex("\nfluid/step +4 +4 ")));
}

// Other programs' work is said in a line, and kept.
TEST_F(Cli, WarnsOfABusyMachine) {
  const pid_t spinner = fork();
  if (spinner == 0)
    for (;;) {
    }
  const std::string json = path("verify.json");
  const Outcome outcome =
      run({"verify", "--kernel", "fluid/advance", "--scene", "single", "--threads", "1", "--json", json});
  kill(spinner, SIGKILL);
  waitpid(spinner, nullptr, 0);
  EXPECT_EQ(outcome.code, 0);
  EXPECT_NE(read_bytes(err_file()).find("cores busy: times will be disturbed\n"), std::string::npos);
  EXPECT_GE(nlohmann::json::parse(read_bytes(json))["machine"]["busy_cores"].get<double>(), .5);
}

// A user's scene goes to the kernels that accept it, and to no others.
TEST_F(Cli, VerifiesAClothOnTheKernelsForIt) {
  const auto verified = [&](const std::string& scene) {
    const std::string json = path("verify.json");
    const Outcome outcome = run({"verify", "--scene", scene, "--threads", "1,2", "--json", json});
    EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
    EXPECT_EQ(outcome.err, "");
    std::set<std::string> kernels;
    const auto report = nlohmann::json::parse(read_bytes(json));
    for (const auto& row : report["rows"]) {
      kernels.insert(row["kernel"].get<std::string>() + ' ' + row["form"].get<std::string>());
      EXPECT_EQ(row["passed"], true) << row;
    }
    return kernels;
  };
  const std::set<std::string> for_meshes = {"cloth/verlet ", "cloth/relax batches", "cloth/relax batches_for_original",
                                            "cloth/collide ", "cloth/step batches"};
  std::set<std::string> all = for_meshes;
  all.insert({"cloth/relax chains", "cloth/relax chains_for_original", "cloth/relax colours",
              "cloth/relax colours_for_original", "cloth/step chains", "cloth/step colours"});
  EXPECT_EQ(verified("scenes/cloth/tiny.toml"), all);
  write_bytes(path("cloth.obj"), good_obj);
  EXPECT_EQ(verified(scene(good_mesh)), for_meshes);
}

// Under gravity momentum is not conserved, so a scene that states otherwise must fail.
TEST_F(Cli, ExitsWithOneWhereACheckFails) {
  const std::string wrong = scene(good_scene + "[holds]\nmomentum_conserved = true\n"), json = path("verify.json");
  const Outcome outcome = run({"verify", "--kernel", "fluid/step", "--form", "owner_gather", "--scene", wrong,
                               "--threads", "1", "--json", json});
  EXPECT_EQ(outcome.code, 1) << outcome.out << outcome.err;
  EXPECT_NE(outcome.out.find("FAILED"), std::string::npos);
  EXPECT_NE(outcome.out.find("0 passed, 1 failed\n"), std::string::npos) << outcome.out;
  const auto report = nlohmann::json::parse(read_bytes(json));
  EXPECT_EQ(report["rows"][0]["passed"], false);
  EXPECT_NE(report["rows"][0]["worst_at"].get<std::string>().find("momentum"), std::string::npos);
}

// What a report cannot be written to is refused before the work, and nothing is printed as if it had been saved.
TEST_F(Cli, RefusesOutputsThatCannotBeWritten) {
  const std::vector<std::string> some = {"--kernel", "fluid/advance", "--scene", "scenes/fluid/single.toml"};
  for (const char* command : {"verify", "bench", "scale"}) {
    std::vector<std::string> arguments = {command, "--json", path("none/x.json")};
    arguments.insert(arguments.end(), some.begin(), some.end());
    expect_refused(arguments, "none/x.json");
    EXPECT_EQ(read_bytes(out_file()), "") << command;
  }
  std::vector<std::string> arguments = {"verify", "--threads", "1"};
  arguments.insert(arguments.end(), some.begin(), some.end());
  const Outcome outcome = end_of(start(arguments, [] {
    const int full = open("/dev/full", O_WRONLY);
    dup2(full, STDOUT_FILENO);
  }));
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.err.find("standard output cannot be written"), std::string::npos) << outcome.err;
}

TEST_F(Cli, BenchesAndReports) {
  const std::string json = path("bench.json");
  const Outcome outcome = run(
      {"bench", "--kernel", "fluid/advance", "--scene", "scenes/fluid/single.toml", "--threads", "1", "--json", json});
  ASSERT_EQ(outcome.code, 0) << outcome.out << outcome.err;
  const auto report = nlohmann::json::parse(read_bytes(json));
  EXPECT_EQ(report["schema"], 1);
  EXPECT_EQ(report["quick"], false);
  expect_machine(report);
  std::set<std::string> variants;
  for (const auto& row : report["rows"]) {
    expect_fields(row, {"kernel", "form", "scene", "variant", "threads", "lanes", "cores", "ms", "least_ms", "spread",
                        "items", "unit", "items_per_s", "bytes", "flops"});
    EXPECT_GT(row["least_ms"].get<double>(), 0);
    EXPECT_LE(row["least_ms"].get<double>(), row["ms"].get<double>());
    EXPECT_GT(row["cores"].get<double>(), 0);
    variants.insert(row["variant"].get<std::string>());
  }
  EXPECT_EQ(variants, (std::set<std::string>{"serial", "openmp"}));
}

// The spread of one sample is no number.
TEST_F(Cli, SaysNoSpreadOfASingleSample) {
  const std::string json = path("bench.json");
  const Outcome outcome =
      run({"bench", "--kernel", "fluid/advance", "--scene", "single", "--threads", "1", "--quick", "--json", json});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.out.find('%'), std::string::npos) << outcome.out;
  const auto report = nlohmann::json::parse(read_bytes(json));
  EXPECT_EQ(report["quick"], true);
  for (const auto& row : report["rows"]) {
    EXPECT_TRUE(row["spread"].is_null());
    EXPECT_TRUE(row["whole_cores"].is_boolean());
  }
}

TEST_F(Cli, BenchesOneSizeOfEachFormQuickly) {
  const std::string json = path("bench.json");
  const auto scenes = [&](const std::string& effort) {
    EXPECT_EQ(run({"bench", "--kernel", "rigid/place_colliders", "--threads", "1", effort, "--json", json}).code, 0);
    std::vector<std::string> found;
    const auto report = nlohmann::json::parse(read_bytes(json));
    for (const auto& row : report["rows"])
      if (row["variant"] == "serial") found.push_back(row["scene"]);
    return found;
  };
  EXPECT_EQ(scenes("--quick"), std::vector<std::string>{"castle"});
  EXPECT_EQ(scenes("--brief"), (std::vector<std::string>{"castle", "boxes_100k"}));
  EXPECT_EQ(run({"bench", "--kernel", "rigid/place_colliders", "--quick", "--brief"}).code, 2);
}

}  // namespace
}  // namespace lockstep
