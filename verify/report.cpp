#include "verify/report.h"

#include <omp.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <thread>

#include "commit.h"  // written by the Makefile: the commit and the flags of this build
#include "common/atomic_file.h"
#include "common/input_error.h"
#include "common/simd.h"
#include "verify/held_team.h"

namespace lockstep::verify {
namespace {

std::string cpu_name() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);)
    if (line.starts_with("model name")) return line.substr(line.find(": ") + 2);
  return "unknown";
}

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

std::string today() {
  const std::time_t time = std::time(nullptr);
  char text[11];
  std::strftime(text, sizeof text, "%F", std::gmtime(&time));
  return text;
}

nlohmann::ordered_json json_of(const std::optional<Shard>& shard) {
  if (!shard) return {};
  return {{"number", shard->number}, {"of", shard->of}};
}

#if defined(__clang__)
constexpr char compiler[] = "clang++ " __clang_version__;
#else
constexpr char compiler[] = "g++ " __VERSION__;
#endif

}  // namespace

std::string version() { return std::string("lockstep ") + LOCKSTEP_COMMIT + ", " + isa_name + ", " + compiler; }

nlohmann::ordered_json machine() {
  return {
      {"cpu", cpu_name()},
      {"cores", std::thread::hardware_concurrency()},
      {"isa", isa_name},
      {"lanes", lanes},
      {"compiler", compiler},
      {"flags", LOCKSTEP_FLAGS},
      {"commit", LOCKSTEP_COMMIT},
      {"date", today()},
      {"omp",
       {{"version", _OPENMP},
        {"max_threads", omp_get_max_threads()},
        {"waits_by", way_to_wait()},
        {"OMP_WAIT_POLICY", environment("OMP_WAIT_POLICY")},
        {"GOMP_SPINCOUNT", environment("GOMP_SPINCOUNT")},
        {"OMP_PROC_BIND", environment("OMP_PROC_BIND")},
        {"OMP_PLACES", environment("OMP_PLACES")},
        {"OMP_SCHEDULE", environment("OMP_SCHEDULE")}}},
  };
}

Report::Report(const ReportOptions& options, const nlohmann::ordered_json& more) : options_(options) {
  on.update(more);
  const std::string& path = options_.json;
  if (path.empty()) return;
  if (options_.resume) read_earlier();
  std::error_code error;
  const bool there = std::filesystem::exists(path, error);
  if (!std::ofstream(path, std::ios::app)) throw InputError(path + ": cannot be written: " + std::strerror(errno));
  if (!there) std::filesystem::remove(path, error);
}

void Report::read_earlier() {
  const std::string& path = options_.json;
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return;
  std::ifstream in(path);
  const auto report = nlohmann::ordered_json::parse(in, nullptr, false);
  const auto part = [](const nlohmann::ordered_json& of, const std::string& name) {
    return of.is_object() ? of.value(name, nlohmann::ordered_json()) : nlohmann::ordered_json();
  };
  const auto expect_same = [&](const std::string& name, const nlohmann::ordered_json& there,
                               const nlohmann::ordered_json& here) {
    if (nlohmann::json(there) != nlohmann::json(here))  // in any order of fields
      throw InputError(path + ": --resume mixes no reports: its " + name + " is " + there.dump() + ", here it is " +
                       here.dump());
  };
  expect_same("schema", part(report, "schema"), schema);
  expect_same("quick", part(report, "quick"), options_.quick);
  expect_same("brief", part(report, "brief"), options_.brief);
  expect_same("shard", part(report, "shard"), json_of(options_.shard));
  // Another command would put other cases at a shard's places.
  if (options_.shard) expect_same("command", part(report, "command"), options_.command);
  for (const auto& [name, here] : on.items())
    if (name != "date") expect_same(name, part(part(report, "machine"), name), here);
  for (const nlohmann::ordered_json& row : part(report, "rows"))
    if (row.is_object()) earlier_.push_back(row);
}

nlohmann::ordered_json Report::take_earlier(const nlohmann::ordered_json& fields) {
  auto taken = nlohmann::ordered_json::array(), others = taken;
  for (nlohmann::ordered_json& row : earlier_) {
    const bool wanted = std::ranges::all_of(fields.items(), [&](const auto& field) {
      return row.contains(field.key()) && row[field.key()] == field.value();
    });
    (wanted ? taken : others).push_back(std::move(row));
  }
  earlier_ = std::move(others);
  return taken;
}

void Report::put_place(nlohmann::ordered_json& row, std::size_t place) const {
  if (options_.shard) row["place"] = place;
}

void Report::keep(const nlohmann::ordered_json& rows) {
  if (now() > written_ + 1) write(rows, false);
}

void Report::finish(const nlohmann::ordered_json& rows) { write(rows, true); }

void Report::write(const nlohmann::ordered_json& rows, bool complete) {
  if (options_.json.empty()) return;
  nlohmann::ordered_json report = {{"schema", schema},
                                   {"command", options_.command},
                                   {"complete", complete},
                                   {"quick", options_.quick},
                                   {"brief", options_.brief},
                                   {"machine", on}};
  if (options_.shard) report["shard"] = json_of(options_.shard);
  report["rows"] = rows;
  write_report(options_.json, report);
  written_ = now();
}

void write_report(const std::string& path, const nlohmann::ordered_json& report) {
  write_file(path, [&](std::ostream& out) { out << report.dump(2) << '\n'; });
}

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

void progress(const std::string& what) {
  if (isatty(STDERR_FILENO)) std::fprintf(stderr, "\r\033[K%s", what.c_str());
}

}  // namespace lockstep::verify
