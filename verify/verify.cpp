// The verifier: runs every selected kernel on its scenes at every thread count, and prints one row each with its
// verdict.
//
// A row passes if its verdict's assertion holds and, unless the kernel is declared order-dependent, its results have
// the same bits at every thread count.
#include <cstdio>
#include <filesystem>
#include <optional>

#include "common/simd.h"
#include "verify/busy.h"
#include "verify/compare.h"
#include "verify/held_team.h"
#include "verify/report.h"
#include "verify/selection.h"
#include "verify/team.h"
#include "verify/verdicts.h"

namespace lockstep::verify {
namespace {

double milliseconds(const std::function<void()>& work) {
  const double start = now();
  work();
  return 1e3 * (now() - start);
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
  Report report(options);
  report.on["busy_cores"] = busy_cores();
  auto rows = nlohmann::ordered_json::array();
  if (!options.only_failed) print_head();
  for (const auto& [kernel, scene_path, place] : selected) {
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
      TeamSizes teams{};
      Judgement judgement;
      hold_team(threads, [&] {
        openmp_ms = milliseconds(run.openmp);
        teams = take_team_sizes();
        judgement = run.judge();
      });
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
      report.put_place(rows.back(), place);
      progress("");
      if (!options.only_failed || !judgement.passed) print_verdict(rows.back());
      report.keep(rows);
    }
  }
  report.finish(rows);
  return sum_up(rows, options.only_failed);
}

}  // namespace lockstep::verify
