// The benchmark: times every selected kernel, serial and openmp at each thread count, in one run on one set of inputs.
//
// Variants take turns, so that a slow second of the machine affects all of them. A row gives the median, the spread
// (the interquartile range over the median), and the least, which is closest to the time on an idle machine.
//
// Samples during which the machine did not give whole cores are dropped (verify/samples.h). A case with too few samples
// left is measured again after all others, for a minute in all. If whole cores cannot be had, the row uses all samples;
// `cores` says how many cores they had.
//
// GB/s and GFLOP/s use the bytes and flops declared beside each kernel. They compare with this machine's peaks, which
// the program measures itself: triad a = b + s c over arrays beyond the caches, and independent fused multiply-adds in
// lanes.
//
// A run that is cut off keeps the rows of the cases that it finished; --resume measures the others.
#include <omp.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <deque>
#include <filesystem>
#include <optional>
#include <thread>

#include "common/simd.h"
#include "verify/busy.h"
#include "verify/costs.h"
#include "verify/held_team.h"
#include "verify/pages.h"
#include "verify/report.h"
#include "verify/samples.h"
#include "verify/selection.h"
#include "verify/team.h"

namespace lockstep::verify {
namespace {

struct Effort {
  std::size_t repeats;  // of a variant
  std::size_t fewest;   // of a variant that takes long: `repeats` would take more than four times `seconds`
  double seconds;       // a variant
  double patience;      // seconds, over all cases, to repeat those that lacked cores
};
constexpr Effort full_effort = {15, 15, .5, 60}, brief_effort = {5, 2, .08, 10}, quick_effort = {1, 1, 0, 0};

struct Variant {
  std::string name;
  int threads;
  std::function<void()> work;
  std::vector<Sample> samples;
  std::string fault = {};  // why its row does not count, if it does not
  int cores() const { return std::min(threads, omp_get_num_procs()); }
};

// The rows of a case, and whether too few of its samples had whole cores.
struct Measured {
  nlohmann::ordered_json rows;
  bool lacks_cores;
};

// `turns`: the highest turns_per_ns of one core so far; updated.
Measured measure(const Kernel& kernel, const std::string& scene_path, const std::vector<int>& threads,
                 const Effort& effort, double& turns) {
  const Case run = [&] {
    const PagesOfTeam near(std::ranges::max(threads));
    return kernel.make(scene_path);
  }();
  // Speed-ups are over the best serial algorithm. If openmp runs another algorithm, its serial form has a row too.
  std::vector<Variant> variants = {{"serial", 1, run.best_serial ? run.best_serial : run.serial, {}}};
  if (run.best_serial) variants.push_back({"serial_twin", 1, run.serial, {}});
  for (int count : threads) variants.push_back({"openmp", count, run.openmp, {}});
  const double seconds_of_all = effort.seconds * variants.size(), start_of_all = now();
  double patience = 4 * seconds_of_all;  // s
  const auto wants = [&](std::size_t repeat) {
    const double since = now() - start_of_all;
    return repeat < effort.fewest || since < seconds_of_all || (repeat < effort.repeats && since < 4 * seconds_of_all);
  };
  for (std::size_t repeat = 0; wants(repeat); ++repeat)
    for (Variant& variant : variants) {
      run.reset();
      double turns_before, turns_after, seconds;
      hold_team(variant.threads, [&] {
        // A team that has shared its cores sleeps at barriers for a spell. A sample would show that, so it waits.
        const double shared = std::min(cores_shared_for(), patience);
        std::this_thread::sleep_for(std::chrono::duration<double>(shared));
        patience -= shared;
        wake_team();
        turns_before = turns_per_ns(variant.threads);
        take_team_sizes();
        const double start = now();
        variant.work();
        seconds = now() - start;
        if (const TeamSizes teams = take_team_sizes(); !teams.are(variant.threads))
          variant.fault = other_team(teams, variant.threads);
        turns_after = turns_per_ns(variant.threads);
      });
      variant.samples.push_back({seconds, std::min(turns_before, turns_after)});
      turns = std::max(turns, std::max(turns_before, turns_after) / variant.cores());
    }

  Measured measured = {nlohmann::ordered_json::array(), false};
  for (const Variant& variant : variants) {
    if (!variant.fault.empty()) {
      std::fprintf(stderr, "lockstep: %s %s on %s: %s; its row is left out\n", kernel.name.c_str(), kernel.form.c_str(),
                   std::filesystem::path(scene_path).stem().c_str(), variant.fault.c_str());
      continue;
    }
    const auto [samples, lack_cores] = counted(variant.samples, turns * variant.cores(), effort.repeats);
    measured.lacks_cores |= lack_cores;
    const double median = quantile(samples, &Sample::seconds, .5);
    const std::optional<double> spread_of_samples = spread(samples);
    const Work& work = run.work;
    measured.rows.push_back(
        {{"kernel", kernel.name},
         {"form", kernel.form},
         {"scene", std::filesystem::path(scene_path).stem().string()},
         {"variant", variant.name},
         {"threads", variant.threads},
         {"lanes", variant.name == "openmp" ? lanes : 1},
         {"cores", quantile(samples, &Sample::turns, .5) / turns},
         {"whole_cores", !lack_cores},
         {"ms", median * 1e3},
         {"least_ms", quantile(samples, &Sample::seconds, 0) * 1e3},
         {"spread", spread_of_samples ? nlohmann::ordered_json(*spread_of_samples) : nlohmann::ordered_json()},
         {"items", work.items},
         {"unit", work.unit},
         {"items_per_s", work.items / median},
         {"bytes", work.bytes},
         {"flops", work.flops}});
    if (variant.name == "openmp" && work.lane_use > 0) measured.rows.back()["lane_use"] = work.lane_use;
  }
  return measured;
}

void print(const nlohmann::ordered_json& row, double serial_ms) {
  const auto text = [&](const char* key) { return row[key].get<std::string>(); };
  const auto number = [&](const char* key) { return row[key].get<double>(); };
  const double ms = number("ms");
  char spread[16] = "-";
  if (!row["spread"].is_null()) std::snprintf(spread, sizeof spread, "%.1f%%", number("spread") * 100);
  std::printf("%-19s %-13s %-15s %-11s %7d %5.2f %9.3f %9.3f %7s %12.4g %7.2f %8.2f %9.2f\n", text("kernel").c_str(),
              text("form").c_str(), text("scene").c_str(), text("variant").c_str(), row["threads"].get<int>(),
              number("cores"), ms, number("least_ms"), spread, number("items_per_s"), number("bytes") / ms * 1e-6,
              number("flops") / ms * 1e-6, serial_ms / ms);
}

// Whether the rows of a case say what is asked for: serial, and openmp at each number of threads.
bool complete(const nlohmann::ordered_json& rows, const std::vector<int>& threads) {
  const auto has = [&](const char* variant, int count) {
    return std::ranges::any_of(rows, [&](const nlohmann::ordered_json& row) {
      return row.value("variant", nlohmann::ordered_json()) == variant &&
             row.value("threads", nlohmann::ordered_json()) == count;
    });
  };
  return has("serial", 1) && std::ranges::all_of(threads, [&](int count) { return has("openmp", count); });
}

}  // namespace

int bench(const Options& options) {
  const std::vector<Selected> selected = select(options, Purpose::bench);
  Report report(options);
  report.on["busy_cores"] = busy_cores();
  for (int threads : options.threads) {
    progress("peaks of the machine");
    report.on["peaks"].push_back({{"threads", threads},
                                  {"triad_gb_per_s", triad_gb_per_s(threads)},
                                  {"fma_gflop_per_s", fma_gflop_per_s(threads)}});
  }
  progress("");
  for (const auto& peak : report.on["peaks"])
    std::printf("peaks at %d threads: triad %.1f GB/s, fma %.1f GFLOP/s\n", peak["threads"].get<int>(),
                peak["triad_gb_per_s"].get<double>(), peak["fma_gflop_per_s"].get<double>());
  std::printf("%-19s %-13s %-15s %-11s %7s %5s %9s %9s %7s %12s %7s %8s %9s\n", "kernel", "form", "scene", "variant",
              "threads", "cores", "ms", "least", "spread", "items/s", "GB/s", "GFLOP/s", "x serial");

  const Effort effort = options.quick ? quick_effort : options.brief ? brief_effort : full_effort;
  std::vector<nlohmann::ordered_json> rows(selected.size());  // of each case
  std::deque<std::size_t> waiting;
  for (std::size_t k = 0; k < selected.size(); ++k) {
    const auto& [kernel, scene_path, place] = selected[k];
    rows[k] = report.take_earlier(
        {{"kernel", kernel.name}, {"form", kernel.form}, {"scene", std::filesystem::path(scene_path).stem().string()}});
    if (complete(rows[k], options.threads)) {
      for (const auto& row : rows[k]) print(row, rows[k][0]["ms"]);
    } else {
      rows[k].clear();
      waiting.push_back(k);
    }
  }
  const auto all_rows = [&] {
    nlohmann::ordered_json all = report.earlier();  // of cases that this run does not select
    for (const auto& of_case : rows) all.insert(all.end(), of_case.begin(), of_case.end());
    return all;
  };
  double turns = 0, patience = effort.patience;
  for (std::size_t first = waiting.size(); !waiting.empty(); first -= first > 0) {
    const std::size_t k = waiting.front();
    waiting.pop_front();
    const bool again = first == 0;
    if (!again || patience > 0) {
      const auto& [kernel, scene_path, place] = selected[k];
      progress(kernel.name + " " + kernel.form + " on " + std::filesystem::path(scene_path).stem().string());
      const double start = now();
      Measured measured = measure(kernel, scene_path, options.threads, effort, turns);
      for (auto& row : measured.rows) report.put_place(row, place);
      progress("");
      if (again) patience -= now() - start;
      if (!again || !measured.lacks_cores) rows[k] = measured.rows;
      report.keep(all_rows());
      if (measured.lacks_cores && patience > 0) {
        waiting.push_back(k);
        continue;
      }
    }
    for (const auto& row : rows[k]) print(row, rows[k][0]["ms"]);
    std::fflush(stdout);
  }
  report.finish(all_rows());
  return 0;
}

}  // namespace lockstep::verify
