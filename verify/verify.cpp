// The verifier: runs every selected kernel on its scenes at every thread count, and prints one row each with its
// verdict.
//
// A row passes if its verdict's assertion holds and, unless the kernel is declared order-dependent, its results have
// the same bits at every thread count.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <optional>

#include "common/simd.h"
#include "verify/busy.h"
#include "verify/compare.h"
#include "verify/held_team.h"
#include "verify/names.h"
#include "verify/report.h"
#include "verify/selection.h"
#include "verify/team.h"

namespace lockstep::verify {
namespace {

double milliseconds(const std::function<void()>& work) {
  const double start = now();
  work();
  return 1e3 * (now() - start);
}

// A line for each kernel: its rows by verdict, and which came nearest to its bound.
void print_kernels(const nlohmann::ordered_json& rows, bool only_failed) {
  struct OfKernel {
    std::string name;
    int rows = 0, failed = 0;
    std::map<std::string, int> verdicts = {};
    double nearest = 0;  // error over bound
  };
  std::vector<OfKernel> kernels;
  for (const auto& row : rows) {
    if (kernels.empty() || kernels.back().name != row["kernel"]) kernels.push_back({row["kernel"]});
    OfKernel& kernel = kernels.back();
    const double error = row["error"], bound = row["bound"];
    ++kernel.rows;
    kernel.failed += !row["passed"].get<bool>();
    ++kernel.verdicts[row["verdict"]];
    if (bound > 0) kernel.nearest = std::max(kernel.nearest, error / bound);
  }
  if (only_failed) std::erase_if(kernels, [](const OfKernel& kernel) { return kernel.failed == 0; });
  if (!kernels.empty())
    std::printf("\n%-27s %5s %6s  %11s  %s\n", "kernel", "rows", "failed", "error/bound", "verdicts");
  for (const OfKernel& kernel : kernels) {
    std::vector<std::string> verdicts;
    for (const auto& [name, count] : kernel.verdicts) verdicts.push_back(std::to_string(count) + ' ' + name);
    char nearest[16] = "-";
    if (kernel.nearest > 0) std::snprintf(nearest, sizeof nearest, "%.3g", kernel.nearest);
    std::printf("%-27s %5d %6d  %11s  %s\n", kernel.name.c_str(), kernel.rows, kernel.failed, nearest,
                joined(verdicts, ", ").c_str());
  }
}

nlohmann::ordered_json json_of(const std::vector<Course>& courses) {
  auto all = nlohmann::ordered_json::array();
  for (const Course& c : courses)
    all.push_back({{"what", c.what}, {"unit", c.unit}, {"from", c.from}, {"found", c.found}, {"bound", c.bound}});
  return all;
}

}  // namespace

int verify(const Options& options) {
  const std::vector<Selected> selected = select(options, Purpose::verify);
  Report report(options.json);
  report.on["busy_cores"] = busy_cores();
  auto rows = nlohmann::ordered_json::array();
  int passed = 0, failed = 0;
  if (!options.only_failed)
    std::printf("%-19s %-13s %-15s %7s %5s  %-9s %10s %10s %9s %9s  %s\n", "kernel", "form", "scene", "threads",
                "lanes", "verdict", "error", "bound", "serial ms", "openmp ms", "worst at");
  for (const auto& [kernel, scene_path] : selected) {
    const std::string scene = std::filesystem::path(scene_path).stem();
    progress(kernel.name + " " + kernel.form + " on " + scene);
    const Case run = kernel.make(scene_path);
    run.reset();
    const double serial_ms = milliseconds(run.serial);
    std::optional<std::uint64_t> first_hash;
    for (int threads : options.threads) {
      run.reset();
      take_team_sizes();
      double openmp_ms = 0;
      hold_team(threads, [&] { openmp_ms = milliseconds(run.openmp); });
      const TeamSizes teams = take_team_sizes();
      Judgement judgement = run.judge();
      if (!teams.are(threads)) {
        judgement.passed = false;
        judgement.worst_at = other_team(teams, threads) + "; " + judgement.worst_at;
      }
      const std::uint64_t hash = run.hash();
      if (!kernel.order_dependent && hash != first_hash.value_or(hash)) {
        judgement.passed = false;
        judgement.worst_at =
            "other bits than at " + std::to_string(options.threads.front()) + " threads; " + judgement.worst_at;
      }
      if (!first_hash) first_hash = hash;
      ++(judgement.passed ? passed : failed);
      progress("");
      if (!options.only_failed || !judgement.passed)
        std::printf("%-19s %-13s %-15s %7d %5d  %-9s %10.3g %10.3g %9.2f %9.2f  %s%s\n", kernel.name.c_str(),
                    kernel.form.c_str(), scene.c_str(), threads, lanes, name_of(judgement.verdict), judgement.error,
                    judgement.bound, serial_ms, openmp_ms, judgement.passed ? "" : "FAILED ",
                    judgement.worst_at.c_str());
      std::fflush(stdout);
      rows.push_back({{"kernel", kernel.name},
                      {"form", kernel.form},
                      {"scene", scene},
                      {"threads", threads},
                      {"lanes", lanes},
                      {"verdict", name_of(judgement.verdict)},
                      {"error", judgement.error},
                      {"bound", judgement.bound},
                      {"worst_at", judgement.worst_at},
                      {"serial_ms", serial_ms},
                      {"openmp_ms", openmp_ms},
                      {"passed", judgement.passed},
                      {"hash", kernel.order_dependent ? "" : std::to_string(hash)}});
      if (!judgement.courses.empty()) rows.back()["courses"] = json_of(judgement.courses);
      report.keep(rows);
    }
  }
  report.finish(rows);
  print_kernels(rows, options.only_failed);
  std::printf("%d passed, %d failed\n", passed, failed);
  return failed == 0 ? 0 : 1;
}

}  // namespace lockstep::verify
