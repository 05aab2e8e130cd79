// Makes one report of the reports of all shards of a command: their rows by the places of their cases, which is the
// order of the command without shards.
//
// Refused are reports of other commits, builds or commands, a shard that is missing, there twice or was cut off, and,
// where rows are times, of other machines. Verdicts may come from machines of several kinds. `shards` keeps the machine
// of each shard; `machine` is that of the first.
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "common/input_error.h"
#include "verify/names.h"
#include "verify/options.h"
#include "verify/report.h"
#include "verify/verdicts.h"

namespace lockstep::verify {
namespace {

using Json = nlohmann::ordered_json;

struct Part {
  std::string path;
  Json report;
  Shard shard;
  std::string command;
};

Part read(const std::string& path) {
  std::ifstream in(path);
  if (!in) throw InputError(path + ": cannot be read");
  try {
    Json report = Json::parse(in);
    if (const Json& is = report.at("schema"); is != schema)
      throw InputError(path + ": its schema is " + is.dump() + ", expected " + std::to_string(schema));
    if (!report.contains("shard")) throw InputError(path + ": is not the report of a shard (--shard)");
    const Shard shard = shard_of(report["shard"].at("number").dump() + '/' + report["shard"].at("of").dump());
    if (!report.at("complete").get<bool>()) throw InputError(path + ": its run was cut off");
    for (const Json& row : report.at("rows"))
      if (!shard.has(row.at("place").get<std::size_t>()))
        throw InputError(path + ": the place " + row["place"].dump() + " of a row is not of its shard");
    const std::string command = report.at("command");
    return {path, std::move(report), shard, command};
  } catch (const Json::exception& error) {
    throw InputError(path + ": is no report: " + error.what());
  }
}

// Whether rows of the command are verdicts, which hold on any machine; others are times.
bool judges(const std::string& command) { return command.starts_with("verify") || command.starts_with("endure"); }

void expect_same_run(const Part& first, const Part& other) {
  const auto field = [](const Part& part, const std::string& path) {
    return part.report.value(Json::json_pointer(path), Json());
  };
  std::vector<std::string> same = {"/command",       "/quick",         "/machine/commit",  "/machine/isa",
                                   "/machine/lanes", "/machine/flags", "/machine/compiler"};
  if (!judges(first.command)) same.insert(same.end(), {"/machine/cpu", "/machine/cores", "/machine/omp"});
  same.push_back("/shard/of");
  for (const std::string& path : same) {
    const Json here = field(other, path), there = field(first, path);
    if (nlohmann::json(here) != nlohmann::json(there))  // in any order of fields
      throw InputError(other.path + ": its " + path.substr(1) + " is " + here.dump() + ", that of " + first.path +
                       " is " + there.dump());
  }
}

// All shards of one run, in their order.
std::vector<Part> read_all(const std::vector<std::string>& paths) {
  std::vector<Part> parts;
  for (const std::string& path : paths) {
    parts.push_back(read(path));
    expect_same_run(parts[0], parts.back());
  }
  std::ranges::sort(parts, {}, [](const Part& part) { return part.shard.number; });
  const auto twice = std::ranges::adjacent_find(parts, {}, [](const Part& part) { return part.shard.number; });
  if (twice != parts.end())
    throw InputError(twice->path + " and " + std::next(twice)->path + ": both are shard " +
                     std::to_string(twice->shard.number));
  std::vector<std::string> missing;
  for (int number = 1; number <= parts[0].shard.of; ++number)
    if (std::ranges::none_of(parts, [&](const Part& part) { return part.shard.number == number; }))
      missing.push_back(std::to_string(number) + '/' + std::to_string(parts[0].shard.of));
  if (!missing.empty()) throw InputError("missing shards: " + joined(missing, ", "));
  return parts;
}

}  // namespace

int merge_reports(const MergeOptions& options) {
  std::vector<Part> parts = read_all(options.reports);
  auto shards = Json::array();
  std::vector<Json> rows;
  for (Part& part : parts) {
    shards.push_back(part.report["machine"]);
    for (Json& row : part.report["rows"]) rows.push_back(std::move(row));
  }
  std::ranges::stable_sort(rows, {}, [](const Json& row) { return row["place"].get<std::size_t>(); });
  for (Json& row : rows) row.erase("place");

  Json whole = parts[0].report;
  whole.erase("shard"), whole.erase("rows");
  whole["shards"] = shards;
  whole["rows"] = rows;
  write_report(options.out, whole);
  if (parts[0].command.starts_with("endure")) return sum_up_endured(whole["rows"]);
  if (judges(parts[0].command)) {
    for (const Json& row : whole["rows"])
      if (!row["passed"].get<bool>()) print_verdict(row);
    return sum_up(whole["rows"], false);
  }
  std::printf("%d rows\n", static_cast<int>(rows.size()));
  return 0;
}

}  // namespace lockstep::verify
