// build/lockstep: the command line. Exit codes: 0 good, 1 a check failed, 2 bad usage or input, 128 + n stopped by
// signal n.
#include <malloc.h>
#include <omp.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <new>
#include <string>
#include <string_view>
#include <vector>

#include "common/input_error.h"
#include "verify/inputs.h"
#include "verify/names.h"
#include "verify/options.h"
#include "verify/program.h"
#include "verify/team.h"

namespace {

using namespace lockstep::verify;

constexpr int max_threads = 1024;
constexpr int all_threads = 0;  // what --threads all becomes
constexpr std::string_view changes_no_row[] = {"--json", "--out", "--failed", "--resume", "--shard"};

CLI::Option* add_kernels(CLI::App* command, Options& options) {
  return command
      ->add_option(
          "--kernel", options.kernels,
          "only these: kernels (fluid/forces,fluid/step), a domain (fluid), a last part (forces), or a pattern "
          "(*/step)")
      ->delimiter(',');
}

void add_selection(CLI::App* command, Options& options) {
  add_kernels(command, options);
  command->add_option("--form", options.form, "only this form of it, such as owner_gather");
  command->add_option("--scene", options.scene, "only this scene: its name (flag_33), or a .toml or .fluid file");
  command->add_option("--json", options.json, "write the rows to this file");
}

CLI::Option* add_threads(CLI::App* command, Options& options) {
  const auto count_or_all = [](std::string& text) {
    if (text != "all") return CLI::Range(1, max_threads)(text);
    text = std::to_string(all_threads);
    return std::string();
  };
  return command
      ->add_option("--threads", options.threads,
                   "at these thread counts, such as 1,2,4; all: 1,2,4,... and as many as there are cores")
      ->delimiter(',')
      ->transform(CLI::Validator(count_or_all, "1 - " + std::to_string(max_threads) + " or all"));
}

void add_quick(CLI::App* command, bool& quick) {
  command->add_flag("--quick", quick, "one sample, and one size of each form, to see that it works");
}

void add_brief(CLI::App* command, bool& brief) {
  command->add_flag("--brief", brief, "fewer samples: as many as figures show")->excludes("--quick");
}

// What the model knows of a machine, given instead of measured here: by its name in reports, in whose unit it is
// multiplied.
void add_costs(CLI::App* command, std::map<std::string, double>& given) {
  struct Cost {
    const char *option, *name;
    double unit;
    const char* meaning;
  };
  for (const Cost& cost :
       {Cost{"--fork-join-us", "fork_join_2_ns", 1e3, "an empty region of two threads; P cores: log2 P times as much"},
        Cost{"--barrier-us", "barrier_2_ns", 1e3, "a barrier of two threads; P cores: log2 P times as much"},
        Cost{"--lock-us", "lock_moved_ns", 1e3, "a lock that another core had last, beyond one's own"},
        Cost{"--dispatch-us", "dispatch_moved_ns", 1e3, "fetching a chunk of a loop after another core"},
        Cost{"--memory-gb-per-s", "memory_gb_per_s", 1, "what all cores together draw from memory"},
        Cost{"--last-level-cache-mb", "last_level_cache_bytes", 1e6,
             "of all last-level caches; what fits is not bound"}})
    command->add_option_function<double>(
        cost.option,
        [&given, cost](double value) {
          if (!(value > 0) || std::isinf(value)) throw CLI::ValidationError(cost.option, "expected a number above 0");
          given[cost.name] = value * cost.unit;
        },
        std::string("another machine's instead of this one's: ") + cost.meaning);
}

void add_shard(CLI::App* command, std::string& shard) {
  command->add_option(
      "--shard", shard,
      "only this share of the cases, such as 2/3, the second of three; `merge` makes one report of all");
}

// The command in words, its options in the program's order, without those that change no row.
std::string in_words(const CLI::App& command) {
  std::string words = command.get_name();
  for (const CLI::Option* option : command.get_options()) {
    const std::string name = option->get_name();
    if (option->count() == 0 || std::ranges::count(changes_no_row, name) > 0) continue;
    words += ' ' + name;
    if (option->get_items_expected_max() == 0) continue;  // a flag
    std::vector<std::string> values = option->results();
    if (name == "--threads") std::ranges::replace(values, std::to_string(all_threads), std::string("all"));
    words += ' ' + joined(values, ",");
  }
  return words;
}

CLI::Option* add_resume(CLI::App* command, bool& resume) {
  return command->add_flag("--resume", resume, "go on from the rows that an earlier run of the same commit left");
}

}  // namespace

int main(int argc, char** argv) {
  // Memory that a kernel frees stays with the process: its next call needs as much, and new pages from the system are
  // slow. A step of 5,000 particles took .57 ms without this and .36 ms with it. A step of 100,000 boxes in a pit, with
  // arrays of more than 32 MB, took 164 ms and 117 ms.
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_TRIM_THRESHOLD, -1);

  // No kernel relies on nested parallel regions. A user's OMP_MAX_ACTIVE_LEVELS would nest the regions of kernels that
  // call each other.
  omp_set_max_active_levels(1);

  CLI::App app(
      "Lockstep: the algorithms of two papers on many-core physics, serial and parallel, verified against each other");
  app.require_subcommand(1);
  app.set_version_flag("--version", version());
  Options options;
  RunOptions run_options;
  std::string shard;  // of the command that is given

  ListOptions list_options;
  CLI::App* list_command = app.add_subcommand("list", "print every kernel, its forms and their scenes");
  CLI::Option* const names =
      list_command->add_option("names", list_options.names, "kernels, forms or scenes: only their names, one a line")
          ->check(CLI::IsMember({"kernels", "forms", "scenes"}));
  list_command->add_flag("--json", list_options.json, "as JSON")->excludes(names);
  list_command->add_flag("--markdown", list_options.markdown, "as the table of README.md")->excludes(names);

  CLI::App* verify_command = app.add_subcommand("verify", "compare every openmp kernel with its serial twin");
  add_selection(verify_command, options);
  add_threads(verify_command, options);
  add_shard(verify_command, shard);
  verify_command->add_flag("--full", options.full, "on all scenes");
  verify_command->add_flag("--failed", options.only_failed, "print only failures");

  CLI::App* bench_command = app.add_subcommand("bench", "time every kernel");
  add_selection(bench_command, options);
  add_threads(bench_command, options);
  add_quick(bench_command, options.quick);
  add_brief(bench_command, options.brief);
  add_resume(bench_command, options.resume)->needs("--json");
  add_shard(bench_command, shard);

  ScaleOptions scale_options;
  CLI::App* scale_command = app.add_subcommand("scale", "model every kernel on more cores than this machine has");
  add_selection(scale_command, scale_options);
  scale_command
      ->add_option("--cores", scale_options.cores, "on these numbers of cores (default: 1,2,4,...,128; quick: 1,2,64)")
      ->delimiter(',')
      ->check(CLI::Range(1, max_threads));
  add_quick(scale_command, scale_options.quick);
  add_brief(scale_command, scale_options.brief);
  add_costs(scale_command, scale_options.given);
  scale_command->add_flag("--full", scale_options.full, "on all scenes");
  add_resume(scale_command, scale_options.resume)->needs("--json");
  add_shard(scale_command, shard);

  CLI::App* run_command = app.add_subcommand("run", "simulate a scene");
  run_command->add_option("--scene", run_options.scene, "a scene's name (flag_33), or a .toml or .fluid file")
      ->required();
  run_command->add_option("--variant", run_options.variant, "serial or openmp (default)")
      ->check(CLI::IsMember({"serial", "openmp"}));
  run_command->add_option("--form", run_options.form, "which form of the step");
  run_command->add_option("--threads", run_options.threads, "how many threads")->check(CLI::Range(1, max_threads));
  run_command->add_option("--frames", run_options.frames, "how many frames (default: as the scene says)")
      ->check(CLI::Range(1, 1 << 30));
  run_command
      ->add_option("--out", run_options.out,
                   "a folder for frames that ParaView opens, a .html page that a browser plays, or a .fluid file (of a "
                   "level set .vti or .vtk) for the last state")
      ->required();
  CLI::Option* resume =
      run_command->add_flag("--resume", run_options.resume, "go on from the last frame in the folder, bit for bit");
  run_command->add_flag("--force", run_options.force, "replace the frames of another run in the folder")
      ->excludes(resume);

  EndureOptions endure_options;
  CLI::App* endure_command =
      app.add_subcommand("endure", "run scenes for many steps: nothing may break, get lost or grow");
  endure_command->add_option("--scene", endure_options.scene,
                             "only this .toml file (default: all below scenes/ that move)");
  endure_command->add_option("--steps", endure_options.steps, "how many steps each")
      ->check(CLI::Range(2, 1 << 30))
      ->capture_default_str();
  endure_command->add_option("--json", endure_options.json, "write the rows to this file");
  add_shard(endure_command, shard);

  FigureOptions figure_options;
  CLI::App* figures_command = app.add_subcommand("figures", "compute what the figures show (make figures draws it)");
  figures_command->add_option("--out", figure_options.out, "a folder")->required();
  figures_command->add_option("--report", figure_options.reports, "only these, such as bench,scale or contact_batches")
      ->delimiter(',');
  for (CLI::Option* option :
       {add_kernels(figures_command, figure_options), add_threads(figures_command, figure_options)})
    option->description("of the reports bench and scale: " + option->get_description());
  add_quick(figures_command, figure_options.quick);
  add_brief(figures_command, figure_options.brief);
  figures_command->add_flag("--full", figure_options.full, "on the largest scenes");
  add_resume(figures_command, figure_options.resume);
  add_shard(figures_command, shard);

  CompareOptions compare_options;
  CLI::App* compare_command = app.add_subcommand("compare", "compare the times of two reports of bench, row by row");
  compare_command->add_option("old", compare_options.before, "a JSON file of bench")->required();
  compare_command->add_option("new", compare_options.after, "another one")->required();

  MergeOptions merge_options;
  CLI::App* merge_command =
      app.add_subcommand("merge", "make one report of those of all shards (--shard) of a command");
  merge_command->add_option("reports", merge_options.reports, "their JSON files, in any order")->required();
  merge_command->add_option("--out", merge_options.out, "the file for the whole report")->required();

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help
    // CLI11 asks for what is missing before it names what it did not understand.
    std::vector<std::string> known;
    for (const CLI::App* command : app.get_subcommands([](CLI::App*) { return true; })) {
      if (!command->parsed() && !app.get_subcommands().empty()) continue;
      known.push_back(command->get_name());
      for (const CLI::Option* option : command->get_options()) known.push_back(option->get_name());
    }
    if (const std::vector<std::string> unknown = app.remaining(true); !unknown.empty())
      std::fprintf(stderr, "lockstep: %s is not known%s\n", unknown.front().c_str(),
                   did_you_mean(unknown.front(), known).c_str());
    else
      std::fprintf(stderr, "lockstep: %s\n", error.what());
    return 2;
  }

  try {
    for (std::string* scene : {&run_options.scene, &endure_options.scene})
      if (!scene->empty()) *scene = scene_file(*scene);
    for (ReportOptions* each :
         {static_cast<ReportOptions*>(&options), static_cast<ReportOptions*>(&scale_options),
          static_cast<ReportOptions*>(&endure_options), static_cast<ReportOptions*>(&figure_options)}) {
      each->command = in_words(*app.get_subcommands().front());
      if (!shard.empty()) each->shard = shard_of(shard);
    }
    if (options.threads.empty() && verify_command->parsed()) options.threads = {1, 2, 3};
    for (Options* each : {&options, static_cast<Options*>(&figure_options)})
      if (each->threads.empty() || std::ranges::count(each->threads, all_threads) > 0)
        each->threads = doubling_to(omp_get_num_procs());
    if (scale_options.cores.empty())
      scale_options.cores =
          scale_options.quick ? std::vector<int>{1, 2, 64} : std::vector<int>{1, 2, 4, 8, 16, 32, 64, 128};
    settles_by_openmp = bench_command->parsed() || scale_command->parsed() || figures_command->parsed();
    const auto command = [&] {
      if (list_command->parsed()) return list(list_options);
      if (verify_command->parsed()) return verify(options);
      if (bench_command->parsed()) return bench(options);
      if (scale_command->parsed()) return scale(scale_options);
      if (endure_command->parsed()) return endure(endure_options, argv);
      if (figures_command->parsed()) return figures(figure_options);
      if (compare_command->parsed()) return compare_reports(compare_options);
      if (merge_command->parsed()) return merge_reports(merge_options);
      return run(run_options);
    };
    const int code = command();
    if (std::fflush(stdout) != 0 || std::ferror(stdout))
      throw lockstep::InputError("the standard output cannot be written");
    return code;
  } catch (const lockstep::InputError& error) {
    std::fprintf(stderr, "lockstep: %s\n", error.what());
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "lockstep: out of memory\n");
  }
  return 2;
}
