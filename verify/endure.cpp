// Runs scenes for many steps, in the form that `run` takes, and asserts of each that
//
//   1. every number stays a number, no particle passes a wall and no body a plane: looked at every hundred steps;
//   2. the memory in use does not grow: at the end not more than at half time, but for less than a byte a step.
//
// Memory is what the process has asked for and not given back, as malloc counts it, to the byte. A leak of one byte a step reaches the
// bound. So does an array that doubles because a scene holds more contacts late than before: a failure says that memory grows, not why.
#include <malloc.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "common/scene.h"
#include "verify/options.h"
#include "verify/report.h"
#include "verify/simulation.h"

namespace lockstep::verify {
namespace {

constexpr int look_every = 100;  // steps

double bytes_in_use() {
  const struct mallinfo2 info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd);
}

// All scenes of the repository that have more than one step.
std::vector<std::string> scenes_that_move() {
  std::vector<std::string> paths;
  for (const auto& entry : std::filesystem::recursive_directory_iterator("scenes"))
    if (entry.path().extension() == ".toml" && kind_of_scene(entry.path()) != "levelset") paths.push_back(entry.path());
  std::ranges::sort(paths);
  return paths;
}

}  // namespace

int endure(const EndureOptions& options) {
  const std::vector<std::string> paths = options.scene.empty() ? scenes_that_move() : std::vector{options.scene};
  const nlohmann::ordered_json on = machine();
  auto rows = nlohmann::ordered_json::array();
  int passed = 0, failed = 0;
  std::printf("%-28s %-10s %9s %8s %9s %14s %14s  %s\n", "scene", "form", "elements", "steps", "seconds", "bytes at half", "bytes at end",
              "verdict");
  for (const std::string& path : paths) {
    RunOptions run;
    run.scene = path;
    const Simulation simulation = make_simulation(run);
    const double start = now();
    double at_half = 0;
    std::string fault;
    int step = 0;
    while (step < options.steps && fault.empty()) {
      simulation.step();
      ++step;
      if (step == options.steps / 2) at_half = bytes_in_use();
      if (step % look_every == 0 || step == options.steps) {
        fault = simulation.fault();
        progress(simulation.name + " step " + std::to_string(step) + " of " + std::to_string(options.steps));
      }
    }
    progress("");
    const double at_end = bytes_in_use(), seconds = now() - start;
    if (fault.empty() && at_end - at_half >= options.steps / 2) fault = "memory grows";
    ++(fault.empty() ? passed : failed);
    std::printf("%-28s %-10s %9d %8d %9.1f %14.0f %14.0f  %s\n", simulation.name.c_str(), simulation.form.c_str(), simulation.elements,
                step, seconds, at_half, at_end, fault.empty() ? "endures" : ("FAILED " + fault).c_str());
    std::fflush(stdout);
    rows.push_back({{"scene", simulation.name},
                    {"form", simulation.form},
                    {"elements", simulation.elements},
                    {"unit", simulation.unit},
                    {"steps", step},
                    {"seconds", seconds},
                    {"bytes_at_half", at_half},
                    {"bytes_at_end", at_end},
                    {"fault", fault},
                    {"passed", fault.empty()}});
  }
  if (!options.json.empty()) write_report(options.json, on, rows);
  std::printf("%d passed, %d failed\n", passed, failed);
  return failed == 0 ? 0 : 1;
}

}  // namespace lockstep::verify
