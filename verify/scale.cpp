// For each number of cores a run is recorded (record.h), then replayed (replay.h) at this machine's costs of forks,
// barriers, locks, chunks and memory (costs.h).
#include "verify/scale.h"

#include <omp.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "verify/busy.h"
#include "verify/costs.h"
#include "verify/held_team.h"
#include "verify/pages.h"
#include "verify/report.h"
#include "verify/samples.h"
#include "verify/selection.h"
#include "verify/team.h"

namespace lockstep::verify {

Effort effort_of(const ReportOptions& options) {
  if (options.quick) return {1, 1, 0, 0, 1};
  return options.brief ? Effort{3, 2, .06, .02, 1} : Effort{3, 3, .2, .05, 3};
}

Model measure_model() {
  progress("what OpenMP and memory cost here");
  Model model = {measure_costs(), last_level_cache(), clock_cost_ns(), 0};
  for (int repeat = 0; repeat < 100; ++repeat) model.turns_per_ns = std::max(model.turns_per_ns, turns_per_ns(1));
  progress("");
  return model;
}

Model less_disturbed(const Model& a, const Model& b) {
  const auto least = [](const Together& one, const Together& two) {
    return Together{std::min(one.one, two.one), std::min(one.two, two.two)};
  };
  const auto less_late = [](const Waking::Late& one, const Waking::Late& two) {
    return Waking::Late{std::min(one.waiting, two.waiting), std::min(one.waker, two.waker)};
  };
  const Costs &x = a.costs, &y = b.costs;
  return {{.fork_join = least(x.fork_join, y.fork_join),
           .barrier = least(x.barrier, y.barrier),
           .waking = {std::min(x.waking.from_yielding, y.waking.from_yielding),
                      less_late(x.waking.falling_asleep, y.waking.falling_asleep),
                      less_late(x.waking.asleep, y.waking.asleep)},
           .lock_moved = std::min(x.lock_moved, y.lock_moved),
           .dispatch = {std::min(x.dispatch.again, y.dispatch.again), std::min(x.dispatch.moved, y.dispatch.moved)},
           .flag = {std::min(x.flag.seen, y.flag.seen), std::min(x.flag.read, y.flag.read)},
           .bytes_per_ns = std::max(x.bytes_per_ns, y.bytes_per_ns)},
          a.last_level_cache_bytes,
          std::min(a.clock_cost_ns, b.clock_cost_ns),
          std::max(a.turns_per_ns, b.turns_per_ns)};
}

nlohmann::ordered_json describe(const Model& model) {
  const Costs& costs = model.costs;
  return {{"fork_join_1_ns", costs.fork_join.one},
          {"fork_join_2_ns", costs.fork_join.two},
          {"barrier_1_ns", costs.barrier.one},
          {"barrier_2_ns", costs.barrier.two},
          {"waking_from_yielding_ns", costs.waking.from_yielding},
          {"waking_from_falling_asleep_ns", costs.waking.falling_asleep.waiting},
          {"waker_from_falling_asleep_ns", costs.waking.falling_asleep.waker},
          {"waking_from_sleep_ns", costs.waking.asleep.waiting},
          {"waker_from_sleep_ns", costs.waking.asleep.waker},
          {"lock_moved_ns", costs.lock_moved},
          {"dispatch_ns", costs.dispatch.again},
          {"dispatch_moved_ns", costs.dispatch.moved},
          {"flag_ns", costs.flag.seen},
          {"flag_read_ns", costs.flag.read},
          {"memory_gb_per_s", costs.bytes_per_ns},
          {"last_level_cache_bytes", model.last_level_cache_bytes},
          {"clock_ns", model.clock_cost_ns}};
}

Model with_given(Model model, const std::map<std::string, double>& given) {
  Costs& costs = model.costs;
  const std::map<std::string, double*> cost = {
      {"fork_join_2_ns", &costs.fork_join.two}, {"barrier_2_ns", &costs.barrier.two},
      {"lock_moved_ns", &costs.lock_moved},     {"dispatch_moved_ns", &costs.dispatch.moved},
      {"memory_gb_per_s", &costs.bytes_per_ns}, {"last_level_cache_bytes", &model.last_level_cache_bytes}};
  for (const auto& [name, value] : given) *cost.at(name) = value;
  model.of_another = !given.empty();
  return model;
}

namespace {

nlohmann::ordered_json less_disturbed(const nlohmann::ordered_json& a, const nlohmann::ordered_json& b) {
  for (const auto* row : {&a, &b})
    if (!row->contains("measured_ms")) return row == &a ? b : a;  // its team was smaller than asked for
  nlohmann::ordered_json row = a["modelled_ms"].get<double>() <= b["modelled_ms"].get<double>() ? a : b;
  const auto rank = [](const nlohmann::ordered_json& r) {
    return std::pair(!r["whole_cores"].get<bool>(), r["measured_ms"].get<double>());
  };
  const auto [lack_cores, measured_ms] = std::min(rank(a), rank(b));
  row["whole_cores"] = !lack_cores;
  row["measured_ms"] = measured_ms;
  row["undisturbed_ms"] = std::min(a["undisturbed_ms"].get<double>(), b["undisturbed_ms"].get<double>());
  row["off_by"] = row["modelled_ms"].get<double>() / measured_ms - 1;
  return row;
}

void print(const nlohmann::ordered_json& row, double first_ms) {
  const double ms = row["modelled_ms"];
  const auto text = [&](const char* key) { return row[key].get<std::string>(); };
  std::printf("%-19s %-13s %-25s %5d %11.3f ", text("kernel").c_str(), text("form").c_str(), text("scene").c_str(),
              row["cores"].get<int>(), ms);
  if (row.contains("off_by"))
    std::printf("%9.3f %+6.1f%% ", row["measured_ms"].get<double>(), 100 * row["off_by"].get<double>());
  else
    std::printf("%9s %7s ", "", "");
  const auto percent = [&](const char* share) { return 100 * row[share].get<double>(); };
  std::printf("%8.2f %11.3f   %3.0f%% %5.0f%% %7.0f%% %4.0f%% %7.0f%% %6.0f%%\n", first_ms / ms,
              row["undisturbed_ms"].get<double>(), percent("work"), percent("serial"), percent("together"),
              percent("locks"), percent("dispatch"), percent("waiting"));
}

// Of the work, the bytes that come from memory: the share of the data that the last-level cache has no room for.
double bytes_of(const Repeatable& what, const Model& model) {
  const double data = what.data > 0 ? what.data : what.bytes, beyond = data - model.last_level_cache_bytes;
  return beyond > 0 ? what.bytes * beyond / data : 0;
}

}  // namespace

Record record_once(const Repeatable& what, int cores, const Model& model) {
  const auto record_with = [&](Waits waits) {
    what.reset();
    return record(cores, what.work, clock_ns, model.clock_cost_ns, waits);
  };
  // One core waits for no other, so where its locks and flags are does not matter.
  if (cores == 1) return record_with(Waits::left_out);
  Record made = record_with(Waits::noted);
  if (has_waits(made)) fit(made, record_with(Waits::left_out));
  return made;
}

Replayed replay(const Record& record, const Repeatable& what, const Model& model) {
  return replay(record, model.costs, bytes_of(what, model));
}

void keep_shorter(Replayed& least, const Replayed& replayed) {
  if (replayed.total < least.total) least = replayed;
}

nlohmann::ordered_json fields_of(const Replayed& r, const Repeatable& what, int cores, const Model& model) {
  const double all = cores * r.total, bytes_per_ns = model.costs.bytes_per_ns;
  // Work that takes no longer than reading the clock has a time of 0, of which nothing is a share.
  const auto share = [&](double part) { return all > 0 ? part / all : 0; };
  return {{"modelled_ms", 1e-6 * r.total},
          {"compute_ms", 1e-6 * r.compute},
          {"memory_ms", bytes_per_ns > 0 ? 1e-6 * bytes_of(what, model) / bytes_per_ns : 0},
          {"work", share(r.work)},
          {"serial", share(r.serial)},
          {"together", share(r.together)},
          {"locks", share(r.locks)},
          {"dispatch", share(r.dispatch)},
          {"waiting", share(r.waiting)}};
}

nlohmann::ordered_json scale_row(const Model& model, const Repeatable& what, int cores, const Effort& effort) {
  const bool here = cores <= omp_get_num_procs() && !model.of_another;
  Replayed r = {.total = std::numeric_limits<double>::infinity()};
  Records records;
  std::vector<Sample> samples;
  bool whole_teams = true;  // whether the measured runs had as many threads as `cores`
  if (here) {
    // The first run of a team finds in the caches what another team left there: it is often longer, and was a fifth
    // shorter where arrays fill the last-level cache.
    what.reset();
    hold_team(cores, what.work);
  }
  const double start_of_all = now(), enough = here ? effort.seconds_here : effort.seconds_beyond;
  const auto wants = [&](int repeat) {
    const double since = now() - start_of_all;
    return repeat < effort.fewest || since < enough || (repeat < effort.least && since < 5 * effort.seconds_here);
  };
  for (int repeat = 0; wants(repeat); ++repeat) {
    Record made = record_once(what, cores, model);
    keep_shorter(r, replay(made, what, model));
    records.add(std::move(made));
    if (!here) continue;
    what.reset();
    hold_team(cores, [&] {
      wake_team();
      const double turns_before = turns_per_ns(cores);
      take_team_sizes();
      const double start = now();
      what.work();
      const double seconds = now() - start;
      whole_teams &= take_team_sizes().are(cores);
      samples.push_back({seconds, std::min(turns_before, turns_per_ns(cores))});
    });
  }
  nlohmann::ordered_json row = {{"cores", cores}};
  row.update(fields_of(r, what, cores, model));
  row["undisturbed_ms"] = 1e-6 * replay(records.least(), what, model).total;
  if (here && whole_teams) {
    const Counted on_cores = counted(samples, cores * model.turns_per_ns, effort.least);
    const double measured_ms = 1e3 * quantile(on_cores.samples, &Sample::seconds, 0);
    row["measured_ms"] = measured_ms;
    row["off_by"] = 1e-6 * r.total / measured_ms - 1;
    row["whole_cores"] = !on_cores.lack_cores;
  }
  return row;
}

int scale(const ScaleOptions& options) {
  const std::vector<Selected> selected = select(options, Purpose::bench);
  Report report(options, {{"given", options.given}});
  report.on["busy_cores"] = busy_cores();
  Model model = with_given(measure_model(), options.given);
  const std::size_t counts = options.cores.size();
  // [selected, cores]; empty until measured
  std::vector<nlohmann::ordered_json> rows(selected.size() * counts, nlohmann::ordered_json::object());
  const auto named = [&](std::size_t row) {
    const auto& [kernel, scene_path, place] = selected[row / counts];
    return nlohmann::ordered_json{
        {"kernel", kernel.name}, {"form", kernel.form}, {"scene", std::filesystem::path(scene_path).stem().string()}};
  };
  for (std::size_t i = 0; i < rows.size(); ++i) {
    nlohmann::ordered_json fields = named(i);
    fields["cores"] = options.cores[i % counts];
    if (const auto earlier = report.take_earlier(fields); !earlier.empty()) rows[i] = earlier[0];
  }
  const auto all_rows = [&] {
    nlohmann::ordered_json all = report.earlier();  // of cases that this run does not select
    std::ranges::copy_if(rows, std::back_inserter(all), [](const auto& row) { return !row.empty(); });
    return all;
  };
  const Effort effort = effort_of(options);
  const int passes = model.of_another ? 1 : effort.passes;
  for (int pass = 0; pass < passes; ++pass) {
    if (pass > 0) model = less_disturbed(model, measure_model());  // never of another machine
    for (std::size_t k = 0; k < selected.size(); ++k) {
      const auto& [kernel, scene_path, place] = selected[k];
      // Passes that a row has: all, or one beyond the machine's cores, where nothing is timed.
      const auto lacks = [&](std::size_t c) {
        const int wanted = options.cores[c] > omp_get_num_procs() ? 1 : pass + 1;
        return rows[k * counts + c].value("passes", 0) < wanted;
      };
      std::vector<std::size_t> missing(counts);
      std::iota(missing.begin(), missing.end(), 0);
      std::erase_if(missing, [&](std::size_t c) { return !lacks(c); });
      if (missing.empty()) continue;
      const std::string scene = std::filesystem::path(scene_path).stem(),
                        what = kernel.name + " " + kernel.form + " on " + scene;
      const std::string when = ", pass " + std::to_string(pass + 1) + " of " + std::to_string(passes);
      progress(what + when);
      const Case run = [&] {
        const PagesOfTeam near(std::min(std::ranges::max(options.cores), omp_get_num_procs()));
        return selected[k].kernel.make(selected[k].scene_path);
      }();
      for (const std::size_t c : missing) {
        const int cores = options.cores[c];
        progress(what + ", " + std::to_string(cores) + " cores" + when);
        nlohmann::ordered_json &kept = rows[k * counts + c], row = named(k * counts);
        const Repeatable what_runs = {run.reset, run.openmp, run.work.bytes, run.work.data};
        row.update(scale_row(model, what_runs, cores, effort));
        const int before = kept.value("passes", 0);
        kept = kept.empty() ? row : less_disturbed(kept, row);
        kept["passes"] = before + 1;
        report.put_place(kept, place);
        report.keep(all_rows());
      }
    }
  }
  progress("");

  report.on["costs"] = describe(model);
  for (const auto& [name, value] : report.on["costs"].items())
    std::printf("%s %.4g\n", name.c_str(), value.get<double>());
  std::printf("%-19s %-13s %-25s %5s %11s %9s %7s %8s %11s   %s\n", "kernel", "form", "scene", "cores", "modelled ms",
              "measured", "off by", "speed-up", "undisturbed",
              "work serial together locks dispatch waiting: of the cores' time");
  for (std::size_t i = 0; i < rows.size(); ++i) print(rows[i], rows[i - i % counts]["modelled_ms"]);
  report.finish(all_rows());
  return 0;
}

}  // namespace lockstep::verify
