// Runs scenes for many steps, in the form that `run` uses, and asserts of each that
//
//   1. no value is NaN or infinite, no particle passes a wall and no body a plane; checked every hundred steps. No
//      cloth of the production passes through itself: checked after every step of a frame;
//   2. steps leak no memory;
//   3. steps that are repeated from a stored state end in the same bits.
//
// A fluid without walls may spread or crowd until its lists would not fit. It is then refused with a message, and
// counted separately.
//
// Arrays grow with their contents: a scene in which more and more bodies touch needs more memory without a leak. So the
// first and the last twentieth of the steps are repeated from the state that they began with. Repeating the same steps
// needs no new capacity, so growth of a byte a step or more is a leak. Which thread finds which contacts depends on
// chance, and so how long each thread's own lists get. If memory did grow, the steps are therefore repeated up to
// `attempts` times: a leak grows each time.
//
// Memory is what the process has allocated and not freed, as malloc counts it, to the byte. malloc counts blocks in a
// thread's own cache as in use, some kilobytes that fill up within hundreds of steps, so that cache is disabled.
#include <malloc.h>
#include <omp.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "common/input_error.h"
#include "verify/domain.h"
#include "verify/held_team.h"
#include "verify/options.h"
#include "verify/report.h"
#include "verify/simulation.h"
#include "verify/verdicts.h"

namespace lockstep::verify {
namespace {

constexpr int check_every = 100;  // steps
constexpr int attempts = 5;

// malloc reads its tunables when a program starts, so the program starts anew with threads' caches disabled.
void disable_thread_caches(char** argv) {
  const char* given = std::getenv("GLIBC_TUNABLES");
  std::string tunables = given ? given : "";
  if (tunables.find("glibc.malloc.tcache_count") != std::string::npos) return;
  if (!tunables.empty()) tunables += ':';
  setenv("GLIBC_TUNABLES", (tunables + "glibc.malloc.tcache_count=0").c_str(), 1);
  execv("/proc/self/exe", argv);
  throw InputError(std::string("endure: the program cannot be started anew: ") + std::strerror(errno));
}

double bytes_in_use() {
  const struct mallinfo2 info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd);
}

// The arrays that the next step needs.
using State = std::vector<std::vector<std::byte>>;

State copy_of(const std::vector<Kept>& arrays) {
  State state;
  for (const Kept& array : arrays) {
    const std::span<const std::byte> bytes = array.bytes();
    state.emplace_back(bytes.begin(), bytes.end());
  }
  return state;
}

void restore(const State& state, const std::vector<Kept>& arrays) {
  for (std::size_t k = 0; k < state.size(); ++k) std::ranges::copy(state[k], arrays[k].room(state[k].size()).begin());
}

// A simulation in progress.
struct Endurance {
  const Simulation& simulation;
  int steps;  // to run
  int made = 0;
  std::string fault = {};    // the first fault; "" if none
  std::string refusal = {};  // why a step was refused; "" if none was
  double left_over = 0;      // bytes that repeated steps left allocated

  void go(int count) {
    for (int i = 0; i < count && fault.empty(); ++i) {
      simulation.step();
      if (++made % check_every == 0 || i == count - 1) {
        fault = simulation.fault();
        progress(simulation.name + " step " + std::to_string(made) + " of " + std::to_string(steps));
      }
    }
  }

  void go_and_again(int count) {
    const State begin = copy_of(simulation.state);
    go(count);
    const State end = copy_of(simulation.state);
    double growth = count;
    for (int attempt = 0; attempt < attempts && growth >= count && fault.empty(); ++attempt) {
      restore(begin, simulation.state);
      const double before = bytes_in_use();
      made -= count;
      go(count);
      growth = bytes_in_use() - before;
      if (fault.empty() && copy_of(simulation.state) != end) fault = "other bits the second time";
    }
    left_over = std::max(left_over, growth);
    if (fault.empty() && growth >= count) fault = "memory grows";
  }
};

// A scene and how many steps it is to make.
struct Task {
  std::string path;
  int steps;
};

// Made for some sixty cores (notes/big_machine.md): 20,000 steps of one would take two cores a day. SCENE= runs it.
const std::set<std::string> for_many_cores = {"castles_4", "castles_16", "hull_soup_100k", "flag_1024", "dam_break_2m"};

// All other scenes of the repository that have more than one step, or those that their domain chooses.
std::vector<Task> scenes_that_move(int steps) {
  std::vector<Task> tasks;
  for (const auto& entry : std::filesystem::recursive_directory_iterator("scenes")) {
    if (entry.path().extension() != ".toml") continue;
    const Domain& domain = domain_of_scene(entry.path());
    const std::string name = entry.path().stem().string();
    if (for_many_cores.contains(name)) continue;
    const bool chosen = domain.endure.empty() || std::ranges::find(domain.endure, name) != domain.endure.end();
    if (domain.moves && chosen) tasks.push_back({entry.path(), std::min(steps, domain.most_steps)});
  }
  std::ranges::sort(tasks, {}, &Task::path);
  return tasks;
}

}  // namespace

int endure(const EndureOptions& options, char** argv) {
  disable_thread_caches(argv);
  const std::vector<Task> tasks =
      options.scene.empty() ? scenes_that_move(options.steps) : std::vector<Task>{{options.scene, options.steps}};
  Report report(options);
  auto rows = nlohmann::ordered_json::array();
  std::printf("%-28s %-10s %9s %8s %9s %12s %9s  %s\n", "scene", "form", "elements", "steps", "seconds", "bytes",
              "left over", "verdict");
  for (std::size_t place = 0; place < tasks.size(); ++place) {
    if (!in_share(options.shard, place)) continue;
    const auto& [path, steps] = tasks[place];
    RunOptions run;
    run.scene = path, run.watch = true;
    const Simulation simulation = make_simulation(run);
    const double start = now();
    Endurance endurance = {.simulation = simulation, .steps = steps};
    const int again = (steps + 19) / 20;
    try {
      hold_team(omp_get_max_threads(), [&] {
        endurance.go_and_again(again);
        endurance.go(endurance.steps - 2 * again);
        endurance.go_and_again(again);
      });
    } catch (const InputError& error) {
      endurance.refusal = error.what();
    }
    progress("");
    const double bytes = bytes_in_use(), seconds = now() - start;
    const std::string &fault = endurance.fault, &refusal = endurance.refusal;
    const std::string verdict = !fault.empty()     ? "FAILED " + fault
                                : !refusal.empty() ? "refused: " + refusal
                                                   : "endures";
    std::printf("%-28s %-10s %9d %8d %9.1f %12.0f %9.0f  %s\n", simulation.name.c_str(), simulation.form.c_str(),
                simulation.elements, endurance.made, seconds, bytes, endurance.left_over, verdict.c_str());
    std::fflush(stdout);
    rows.push_back({{"scene", simulation.name},
                    {"form", simulation.form},
                    {"elements", simulation.elements},
                    {"unit", simulation.unit},
                    {"steps", endurance.made},
                    {"seconds", seconds},
                    {"bytes", bytes},
                    {"bytes_left_over", endurance.left_over},
                    {"fault", fault},
                    {"refusal", refusal}});
    report.put_place(rows.back(), place);
  }
  report.finish(rows);
  return sum_up_endured(rows);
}

}  // namespace lockstep::verify
