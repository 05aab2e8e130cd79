// A record of a run for each number of cores (record.h) is replayed (replay.h) at what forks, barriers, locks, chunks and memory cost here
// (costs.h).
#include "verify/scale.h"

#include <omp.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <limits>

#include "verify/costs.h"
#include "verify/report.h"
#include "verify/selection.h"

namespace lockstep::verify {

Model measure_model() {
  progress("what OpenMP and memory cost here");
  const Model model = {measure_costs(), clock_cost_ns()};
  progress("");
  return model;
}

nlohmann::ordered_json describe(const Model& model) {
  const Costs& costs = model.costs;
  return {{"fork_join_1_ns", costs.fork_join.one}, {"fork_join_2_ns", costs.fork_join.two},
          {"barrier_1_ns", costs.barrier.one},     {"barrier_2_ns", costs.barrier.two},
          {"lock_ns", costs.lock.again},           {"lock_moved_ns", costs.lock.moved},
          {"dispatch_ns", costs.dispatch.again},   {"dispatch_moved_ns", costs.dispatch.moved},
          {"memory_gb_per_s", costs.bytes_per_ns}, {"last_level_cache_bytes", last_level_cache()},
          {"clock_ns", model.clock_cost_ns}};
}

namespace {

// How often to record and to time: so often at the least, at the most, and as fits the time between.
struct Effort {
  int least, most;
  double seconds;
};
constexpr Effort full_effort = {3, 50, .2}, quick_effort = {1, 1, 0};

}  // namespace

nlohmann::ordered_json scale_row(const Model& model, const Repeatable& what, int cores, bool quick) {
  const double bytes = what.bytes > last_level_cache() ? what.bytes : 0;
  const bool here = cores <= omp_get_num_procs();
  Replayed r = {.total = std::numeric_limits<double>::infinity()};
  double measured_ms = r.total;
  const Effort effort = quick ? quick_effort : full_effort;
  const double enough = now() + effort.seconds;
  for (int repeat = 0; repeat < effort.least || (repeat < effort.most && now() < enough); ++repeat) {
    what.reset();
    const Replayed each = replay(record(cores, what.work, clock_ns, model.clock_cost_ns), model.costs, bytes);
    if (each.total < r.total) r = each;
    if (!here) continue;
    omp_set_num_threads(cores);
    what.reset();
    wake_team();
    const double start = now();
    what.work();
    measured_ms = std::min(measured_ms, 1e3 * (now() - start));
  }
  const double ms = 1e-6 * r.total, all = cores * r.total;
  nlohmann::ordered_json row = {{"cores", cores},
                                {"modelled_ms", ms},
                                {"compute_ms", 1e-6 * r.compute},
                                {"memory_ms", model.costs.bytes_per_ns > 0 ? 1e-6 * bytes / model.costs.bytes_per_ns : 0},
                                {"work", r.work / all},
                                {"serial", r.serial / all},
                                {"together", r.together / all},
                                {"locks", r.locks / all},
                                {"dispatch", r.dispatch / all},
                                {"waiting", r.waiting / all}};
  if (here) {
    row["measured_ms"] = measured_ms;
    row["off_by"] = ms / measured_ms - 1;
  }
  return row;
}

int scale(const ScaleOptions& options) {
  const Model model = measure_model();
  nlohmann::ordered_json on = machine();
  on["costs"] = describe(model);
  for (const auto& [name, value] : on["costs"].items()) std::printf("%s %.4g\n", name.c_str(), value.get<double>());
  std::printf("%-19s %-13s %-25s %5s %11s %9s %7s %8s   %s\n", "kernel", "form", "scene", "cores", "modelled ms", "measured", "off by",
              "speed-up", "work serial together locks dispatch waiting: of the cores' time");

  auto rows = nlohmann::ordered_json::array();
  for (const auto& [kernel, scene_path] : select(options, Purpose::bench)) {
    const std::string scene = std::filesystem::path(scene_path).stem();
    progress(kernel.name + " " + kernel.form + " on " + scene);
    const Case run = kernel.make(scene_path);
    double first_ms = 0;
    for (const int cores : options.cores) {
      progress(kernel.name + " " + kernel.form + " on " + scene + ", " + std::to_string(cores) + " cores");
      const nlohmann::ordered_json row = scale_row(model, {run.reset, run.openmp, run.work.bytes}, cores, options.quick);
      progress("");
      const double ms = row["modelled_ms"];
      if (first_ms == 0) first_ms = ms;
      std::printf("%-19s %-13s %-25s %5d %11.3f ", kernel.name.c_str(), kernel.form.c_str(), scene.c_str(), cores, ms);
      if (row.contains("off_by"))
        std::printf("%9.3f %+6.1f%% ", row["measured_ms"].get<double>(), 100 * row["off_by"].get<double>());
      else
        std::printf("%9s %7s ", "", "");
      const auto percent = [&](const char* share) { return 100 * row[share].get<double>(); };
      std::printf("%8.2f   %3.0f%% %5.0f%% %7.0f%% %4.0f%% %7.0f%% %6.0f%%\n", first_ms / ms, percent("work"), percent("serial"),
                  percent("together"), percent("locks"), percent("dispatch"), percent("waiting"));
      std::fflush(stdout);
      nlohmann::ordered_json named = {{"kernel", kernel.name}, {"form", kernel.form}, {"scene", scene}};
      named.update(row);
      rows.push_back(named);
    }
  }
  if (!options.json.empty()) write_report(options.json, on, rows);
  return 0;
}

}  // namespace lockstep::verify
