// The benchmark: times every selected kernel, serial and openmp at each thread count, in one run on one set of inputs.
//
// Variants take turns, so that a slow second of the machine falls on all of them; the row gives the median and the spread
// (the interquartile range over the median). GB/s and GFLOP/s come from the bytes and flops declared beside each kernel and
// stand against this machine's peaks, which the program measures itself: triad a = b + s c over arrays beyond the caches, and
// independent fused multiply-adds in lanes.
#include <omp.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "common/simd.h"
#include "verify/costs.h"
#include "verify/report.h"
#include "verify/selection.h"

namespace lockstep::verify {
namespace {

// Of a variant.
struct Effort {
  int repeats;
  double seconds;
};
constexpr Effort full_effort = {15, .5}, quick_effort = {1, 0};

struct Variant {
  std::string name;
  int threads;
  std::function<void()> work;
  std::vector<double> seconds;
};

double quantile(const std::vector<double>& sorted, double q) { return sorted[static_cast<std::size_t>(q * (sorted.size() - 1))]; }

}  // namespace

int bench(const Options& options) {
  nlohmann::ordered_json on = machine();
  for (int threads : options.threads) {
    progress("peaks of the machine");
    on["peaks"].push_back(
        {{"threads", threads}, {"triad_gb_per_s", triad_gb_per_s(threads)}, {"fma_gflop_per_s", fma_gflop_per_s(threads)}});
  }
  progress("");
  for (const auto& peak : on["peaks"])
    std::printf("peaks at %d threads: triad %.1f GB/s, fma %.1f GFLOP/s\n", peak["threads"].get<int>(),
                peak["triad_gb_per_s"].get<double>(), peak["fma_gflop_per_s"].get<double>());
  std::printf("%-19s %-13s %-15s %-11s %7s %9s %7s %12s %7s %8s %9s\n", "kernel", "form", "scene", "variant", "threads", "ms", "spread",
              "items/s", "GB/s", "GFLOP/s", "x serial");

  auto rows = nlohmann::ordered_json::array();
  for (const auto& [kernel, scene_path] : select(options, Purpose::bench)) {
    const std::string scene = std::filesystem::path(scene_path).stem();
    progress(kernel.name + " " + kernel.form + " on " + scene);
    const Case run = kernel.make(scene_path);
    // Speed-ups are over the best serial algorithm; where openmp runs another one, what that costs in serial has a row too.
    std::vector<Variant> variants = {{"serial", 1, run.best_serial ? run.best_serial : run.serial, {}}};
    if (run.best_serial) variants.push_back({"serial_twin", 1, run.serial, {}});
    for (int threads : options.threads) variants.push_back({"openmp", threads, run.openmp, {}});
    const Effort effort = options.quick ? quick_effort : full_effort;
    const double enough = now() + effort.seconds * variants.size();
    for (int repeat = 0; repeat < effort.repeats || now() < enough; ++repeat)
      for (Variant& variant : variants) {
        omp_set_num_threads(variant.threads);
        run.reset();
        wake_team();
        const double start = now();
        variant.work();
        variant.seconds.push_back(now() - start);
      }
    progress("");
    double serial_median = 0;
    for (Variant& variant : variants) {
      std::sort(variant.seconds.begin(), variant.seconds.end());
      const double median = quantile(variant.seconds, .5);
      const double spread = (quantile(variant.seconds, .75) - quantile(variant.seconds, .25)) / median;
      if (variant.name == "serial") serial_median = median;
      const Work& work = run.work;
      std::printf("%-19s %-13s %-15s %-11s %7d %9.3f %6.1f%% %12.4g %7.2f %8.2f %9.2f\n", kernel.name.c_str(), kernel.form.c_str(),
                  scene.c_str(), variant.name.c_str(), variant.threads, median * 1e3, spread * 100, work.items / median,
                  work.bytes / median * 1e-9, work.flops / median * 1e-9, serial_median / median);
      std::fflush(stdout);
      rows.push_back({{"kernel", kernel.name},
                      {"form", kernel.form},
                      {"scene", scene},
                      {"variant", variant.name},
                      {"threads", variant.threads},
                      {"lanes", variant.name == "openmp" ? lanes : 1},
                      {"ms", median * 1e3},
                      {"spread", spread},
                      {"items", work.items},
                      {"unit", work.unit},
                      {"items_per_s", work.items / median},
                      {"bytes", work.bytes},
                      {"flops", work.flops}});
      if (variant.name == "openmp" && work.lane_use > 0) rows.back()["lane_use"] = work.lane_use;
    }
  }
  if (!options.json.empty()) write_report(options.json, on, rows);
  return 0;
}

}  // namespace lockstep::verify
