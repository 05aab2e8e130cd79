// Simulates a scene and writes what became of it.
#include <omp.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "common/input_error.h"
#include "common/scene.h"
#include "verify/options.h"
#include "verify/report.h"
#include "verify/simulation.h"

namespace lockstep::verify {
namespace {

void make_folder(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error) throw InputError(path + ": cannot be made: " + error.message());
}

Simulation simulation_of(const RunOptions& options) {
  const std::string kind = kind_of_scene(options.scene);
  if (kind == "cloth") return cloth_simulation(options);
  if (kind == "levelset") return levelset_simulation(options);
  if (kind == "rigid") return rigid_simulation(options);
  return fluid_simulation(options);
}

// Whether one file is asked for, and not a folder of frames.
bool wants_one_file(const std::string& out, const std::vector<std::string>& formats) {
  const std::string extension = std::filesystem::path(out).extension();
  if (std::ranges::find(formats, extension) != formats.end()) return true;
  for (const char* other : {".fluid", ".vti", ".vtk"})
    if (extension == other)
      throw InputError("--out " + out + ": this kind of scene is not written as " + other + "; a folder is for frames");
  return false;
}

}  // namespace

int run(const RunOptions& options) {
  const Simulation simulation = simulation_of(options);
  if (options.threads > 0) omp_set_num_threads(options.threads);
  const int frames = options.frames > 0 ? options.frames : simulation.frames;
  const bool one_file = wants_one_file(options.out, simulation.state_formats);
  if (!one_file) make_folder(options.out);

  const auto write_frame = [&](int frame) {
    char name[32];
    std::snprintf(name, sizeof name, "/frame_%05d.vtk", frame);
    if (!one_file) simulation.write_frame(options.out + name);
  };

  write_frame(0);
  double seconds = 0;
  for (int frame = 1; frame <= frames; ++frame) {
    const double start = now();
    simulation.step();
    seconds += now() - start;
    write_frame(frame);
    progress("frame " + std::to_string(frame) + " of " + std::to_string(frames));
  }
  progress("");
  if (one_file) simulation.write_state(options.out);
  const char* unit = simulation.unit.c_str();
  std::printf("%s: %d %s, %d frames, %s %s on %d threads: %.2f ms a frame, %.3g %s a second; wrote %s\n", simulation.name.c_str(),
              simulation.elements, unit, frames, options.variant.c_str(), simulation.form.c_str(),
              options.variant == "serial" ? 1 : omp_get_max_threads(), 1e3 * seconds / frames,
              simulation.elements * double(frames) / seconds, unit, options.out.c_str());
  if (simulation.summary) std::printf("%s\n", simulation.summary().c_str());
  return 0;
}

}  // namespace lockstep::verify
