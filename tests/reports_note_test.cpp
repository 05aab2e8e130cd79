// notes/reports.md names every field of every report, and no other. Run from the root of the repository.
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <string>

#include "tests/cli.h"

namespace lockstep {
namespace {

using Fields = std::set<std::string>;

// The paths of a report's fields, such as machine.omp.version; elements of arrays have no name of their own.
void collect(const nlohmann::json& value, const std::string& path, Fields& fields) {
  if (value.is_object() && !value.empty())
    for (const auto& [name, part] : value.items()) collect(part, path.empty() ? name : path + '.' + name, fields);
  else if (value.is_array() && !value.empty())
    for (const auto& part : value) collect(part, path, fields);
  else
    fields.insert(path);
}

// The first columns of the tables, by the heading that they stand under.
std::map<std::string, Fields> documented() {
  std::map<std::string, Fields> fields;
  std::ifstream note("notes/reports.md");
  std::string heading, line;
  while (std::getline(note, line)) {
    if (line.starts_with("## ")) heading = line.substr(3);
    std::smatch match;
    if (!std::regex_match(line, match, std::regex("\\| `([^`]+)` \\| [^|]+ \\| [^|]+ \\|"))) continue;
    fields[heading].insert(match[1]);
  }
  for (const char* command : {"verify", "bench", "scale", "endure", "figures", "list"})
    fields[command].merge(Fields(fields["every report"]));
  for (const char* field : {"quick", "brief", "command", "complete"}) fields["list"].erase(field);
  // Reports of figures have costs, and rows of the model, as scale has them.
  const Fields not_of_figures = {"rows.passes", "machine.given"};
  for (const std::string& field : fields["scale"])
    if (!not_of_figures.contains(field)) fields["figures"].insert(field);
  return fields;
}

struct ReportsNote : Cli {
  void expect_documented(const std::string& command, const Fields& found) {
    EXPECT_EQ(documented()[command], found) << command;
  }
  Fields fields_of(std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--json", path("report.json")});
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    Fields found;
    collect(nlohmann::json::parse(read_bytes(path("report.json"))), "", found);
    return found;
  }
  void expect_documented(const std::vector<std::string>& arguments) {
    expect_documented(arguments[0], fields_of(arguments));
  }
};

TEST_F(ReportsNote, NamesFieldsOfVerify) {
  expect_documented(
      {"verify", "--kernel", "fluid/step", "--form", "pair_lists", "--scene", "adrift", "--threads", "1"});
}
TEST_F(ReportsNote, NamesFieldsOfBench) {
  expect_documented({"bench", "--kernel", "cloth/relax", "--scene", "rope", "--threads", "1", "--quick"});
}
TEST_F(ReportsNote, NamesFieldsOfScale) {
  expect_documented({"scale", "--kernel", "cloth/verlet", "--scene", "rope", "--cores", "1", "--quick"});
}
// What the report of a shard has besides, and what the merged report has instead.
TEST_F(ReportsNote, NamesFieldsOfShards) {
  const std::vector<std::string> rope = {"endure", "--scene", "rope", "--steps", "40"};
  std::vector<std::string> shard = rope;
  shard.insert(shard.end(), {"--shard", "1/1"});
  Fields expected = documented()["endure"], more = documented()["Shards"], found = fields_of(shard);
  more.erase("shards");
  expected.merge(Fields(more));
  EXPECT_EQ(found, expected);

  ASSERT_EQ(run({"merge", path("report.json"), "--out", path("merged.json")}).code, 0);
  auto merged = nlohmann::json::parse(read_bytes(path("merged.json")));
  EXPECT_EQ(merged["shards"], nlohmann::json::array({merged["machine"]}));
  merged["shards"] = nlohmann::json();
  found.clear();
  collect(merged, "", found);
  expected = documented()["endure"];
  expected.insert("shards");
  EXPECT_EQ(found, expected);
}

TEST_F(ReportsNote, NamesFieldsOfEndure) { expect_documented({"endure", "--scene", "rope", "--steps", "40"}); }

TEST_F(ReportsNote, NamesFieldsOfList) {
  Fields found;
  collect(nlohmann::json::parse(run({"list", "--json"}).out), "", found);
  expect_documented("list", found);
}

TEST_F(ReportsNote, NamesFieldsOfFigures) {
  ASSERT_EQ(run({"figures", "--quick", "--kernel", "cloth/verlet", "--out", folder}).code, 0);
  Fields found;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (const auto report = entry.path().stem(); report != "bench" && report != "scale")
      collect(nlohmann::json::parse(read_bytes(entry.path())), "", found);
  expect_documented("figures", found);
  for (const char* report : {"bench.json", "scale.json"})
    for (const auto& row : nlohmann::json::parse(read_bytes(path(report)))["rows"])
      EXPECT_EQ(row["kernel"], "cloth/verlet") << report;
}

}  // namespace
}  // namespace lockstep
