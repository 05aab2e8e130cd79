// Simulates a scene and writes what became of it.
#include <omp.h>
#include <sys/stat.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "common/fluid/densities.h"
#include "common/fluid/file.h"
#include "common/fluid/rebuild_grid.h"
#include "common/fluid/scene.h"
#include "common/fluid/vtk.h"
#include "common/input_error.h"
#include "verify/fluid_forms.h"
#include "verify/options.h"
#include "verify/report.h"

namespace lockstep::verify {
namespace {

const StepForm& find_form(const RunOptions& options) {
  std::string known;
  for (const StepForm& form : step_forms) {
    if (form.variant == options.variant && (options.form.empty() || form.form == options.form)) return form;
    if (form.variant == options.variant) known += (known.empty() ? "" : ", ") + form.form;
  }
  throw InputError("--form " + options.form + ": expected one of: " + known);
}

void make_folder(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error) throw InputError(path + ": cannot be made: " + error.message());
}

}  // namespace

int run(const RunOptions& options) {
  fluid::Scene scene = fluid::load_scene(options.scene);
  const StepForm& form = find_form(options);
  if (options.threads > 0) omp_set_num_threads(options.threads);
  const int frames = options.frames > 0 ? options.frames : scene.frames;
  const bool one_file = std::filesystem::path(options.out).extension() == ".fluid";
  if (!one_file) make_folder(options.out);

  fluid::Fluid<float> state = fluid::make_fluid(fluid::convert<float>(scene.model), std::move(scene.particles));
  // Frame 0 is the start: its densities, for ParaView's colours, are the one thing it does not have yet.
  const auto write_frame = [&](int frame) {
    if (one_file) return;
    if (frame == 0) {
      fluid::serial::rebuild_grid(state.grid, state.particles, state.sorted);
      fluid::serial::densities_symmetric(state.model, state.grid, state.particles, state.neighbours, state.density);
    }
    char name[32];
    std::snprintf(name, sizeof name, "/frame_%05d.vtk", frame);
    fluid::write_vtk(options.out + name, state.particles, {state.density.data(), std::size_t(state.particles.count)});
  };

  write_frame(0);
  double seconds = 0;
  for (int frame = 1; frame <= frames; ++frame) {
    const double start = now();
    form.step(state);
    seconds += now() - start;
    write_frame(frame);
    progress("frame " + std::to_string(frame) + " of " + std::to_string(frames));
  }
  progress("");
  if (one_file) fluid::write_fluid(options.out, static_cast<float>(scene.model.particles_per_metre), state.particles);
  std::printf("%s: %d particles, %d frames, %s %s on %d threads: %.2f ms a frame, %.3g particle-steps/s; wrote %s\n", scene.name.c_str(),
              state.particles.count, frames, form.variant.c_str(), form.form.c_str(), form.variant == "serial" ? 1 : omp_get_max_threads(),
              1e3 * seconds / frames, state.particles.count * double(frames) / seconds, options.out.c_str());
  return 0;
}

}  // namespace lockstep::verify
