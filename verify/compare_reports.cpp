// Compares two reports of `bench` row by row: how the median changed, and whether by more than the spread of either
// report's repeats.
//
// A row is named by kernel, form, scene, variant and threads. The spread is the interquartile range over the median, so
// that a change of more than both spreads is beyond what the repeats of one run differ by. Nothing is said of rows
// whose spread is unknown (a single repeat) or that never had whole cores.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <string>

#include "common/input_error.h"
#include "verify/options.h"
#include "verify/report.h"

namespace lockstep::verify {
namespace {

struct Time {
  double ms;
  nlohmann::ordered_json spread;  // null if unknown
  bool whole_cores;
};

struct Benched {
  std::string machine;
  std::vector<std::string> names;  // of the rows, in their order
  std::map<std::string, Time> times;
};

Benched read(const std::string& path) {
  std::ifstream in(path);
  if (!in) throw InputError(path + ": cannot be read");
  try {
    const auto report = nlohmann::ordered_json::parse(in);
    const auto& machine = report.at("machine");
    Benched benched;
    for (const char* what : {"cpu", "cores", "isa", "compiler", "commit"})
      benched.machine += (benched.machine.empty() ? "" : ", ") + machine.at(what).dump();
    if (report.at("quick").get<bool>()) benched.machine += ", quick";
    for (const auto& row : report.at("rows")) {
      char name[256];
      const auto text = [&](const char* key) { return row.at(key).get<std::string>(); };
      std::snprintf(name, sizeof name, "%-27s %-20s %-20s %-11s %7d", text("kernel").c_str(), text("form").c_str(),
                    text("scene").c_str(), text("variant").c_str(), row.at("threads").get<int>());
      benched.names.push_back(name);
      benched.times[name] = {row.at("ms"), row.at("spread"), row.at("whole_cores")};
    }
    return benched;
  } catch (const nlohmann::json::exception& error) {
    throw InputError(path + ": is no report of bench: " + error.what());
  }
}

const char* verdict(const Time& before, const Time& after) {
  if (!before.whole_cores || !after.whole_cores) return "no whole cores";
  if (before.spread.is_null() || after.spread.is_null()) return "spread unknown";
  const double change = after.ms / before.ms - 1;
  if (std::abs(change) <= std::max(before.spread.get<double>(), after.spread.get<double>())) return "within";
  return change < 0 ? "faster" : "slower";
}

}  // namespace

int compare_reports(const CompareOptions& options) {
  const Benched before = read(options.before), after = read(options.after);
  if (before.machine != after.machine)
    std::printf("not the same: old on %s; new on %s\n", before.machine.c_str(), after.machine.c_str());
  std::printf("%-27s %-20s %-20s %-11s %7s %10s %10s %8s  %s\n", "kernel", "form", "scene", "variant", "threads",
              "old ms", "new ms", "new/old", "beyond both spreads");
  std::map<std::string, int> count;
  for (const std::string& name : before.names) {
    const auto found = after.times.find(name);
    if (found == after.times.end()) continue;
    const Time &was = before.times.at(name), &is = found->second;
    const char* const said = verdict(was, is);
    ++count[said];
    std::printf("%s %10.4g %10.4g %8.3f  %s\n", name.c_str(), was.ms, is.ms, is.ms / was.ms, said);
  }
  for (const std::string& name : before.names)
    if (!after.times.contains(name)) std::printf("%s  only in the old report\n", name.c_str());
  for (const std::string& name : after.names)
    if (!before.times.contains(name)) std::printf("%s  only in the new report\n", name.c_str());
  std::printf("%d faster, %d slower, %d within the spreads, %d unknown\n", count["faster"], count["slower"],
              count["within"], count["spread unknown"] + count["no whole cores"]);
  return 0;
}

}  // namespace lockstep::verify
