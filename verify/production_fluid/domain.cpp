// The production fluid: what `run` and `endure` do with its scenes.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>

#include "common/production_fluid/scene.h"
#include "common/production_fluid/vtk.h"
#include "verify/arrays.h"
#include "verify/domain.h"
#include "verify/production_fluid/forms.h"

namespace lockstep::verify {
namespace {

using namespace production_fluid;

struct Running {
  Scene scene;
  Liquid<float> liquid;
  StepMemory<float> memory;
  double volume_at_start = 0;
  int frames = 0, substeps = 0, iterations = 0;  // since the run began
  double seconds[int(Module::count)] = {};
};

// The volume of the liquid, m^3. A cell that is not solid counts by the share of it that a plane at distance phi would
// cut off.
double volume_of(const Fluid<float>& fluid) {
  const double h = fluid.spacing;
  double volume = 0;
  for (int z = 0; z < fluid.nz; ++z)
    for (int y = 0; y < fluid.ny; ++y)
      for (int x = 0; x < fluid.nx; ++x)
        if (!is_solid(fluid.solid(x, y, z))) volume += liquid_share(fluid.phi(x, y, z), h);
  return volume * h * h * h;
}

void step(Running& run, Step<float>* step) {
  step(run.scene.model, run.liquid, run.memory);
  ++run.frames, run.substeps += run.memory.substeps, run.iterations += run.memory.iterations;
  for (int k = 0; k < int(Module::count); ++k) run.seconds[k] += run.memory.seconds[k];
}

// With sources no change in percent is given: at the start there may have been no liquid.
std::string volume_text(const Running& run) {
  char text[80];
  const double volume = volume_of(run.liquid.fluid), change = 100 * (volume / run.volume_at_start - 1);
  if (run.scene.model.sources.empty())
    std::snprintf(text, sizeof text, "volume %+.2f %% since the start", change);
  else
    std::snprintf(text, sizeof text, "volume %.4g m^3, at the start %.4g m^3", volume, run.volume_at_start);
  return text;
}

std::string summary_of(const Running& run) {
  char part[160];
  std::snprintf(part, sizeof part, "; a frame: %.1f substeps, %.1f iterations of the pressure a substep\n",
                double(run.substeps) / run.frames, double(run.iterations) / run.substeps);
  std::string text = volume_text(run) + part, modules = "ms a frame:";
  for (int k = 0; k < int(Module::count); ++k) {
    if (run.seconds[k] == 0) continue;
    std::snprintf(part, sizeof part, " %s %.2f,", name_of_module[k], 1e3 * run.seconds[k] / run.frames);
    if (modules.size() + std::string(part).size() > 120) text += modules + '\n', modules.clear();
    modules += part;
  }
  std::snprintf(part, sizeof part, "%d particles, %d drops of spray", run.liquid.particles.count,
                run.liquid.spray.count);
  return text + modules + ' ' + part;
}

// The volume that there would be without an error, m^3: the liquid of the start, and a cylinder from each source.
double volume_without_error(const Running& run) {
  double volume = run.volume_at_start;
  const double now = run.liquid.frames * run.scene.model.frame;
  for (const Source& s : run.scene.model.sources)
    volume += std::numbers::pi * s.radius * s.radius * std::sqrt(dot(s.velocity, s.velocity)) * std::min(s.until, now);
  return volume;
}

std::string fault_of_volume(const Running& run) {
  const double volume = volume_of(run.liquid.fluid), wanted = volume_without_error(run);
  if (std::abs(volume - wanted) <= run.scene.volume_bound * wanted) return "";
  char text[120];
  std::snprintf(text, sizeof text, "the volume is %.4g m^3, expected %.4g within %.3g %%", volume, wanted,
                100 * run.scene.volume_bound);
  return text;
}

// Particles outside obstacles and inside the box, drops inside the box: as the contracts say. The volume within the
// scene's bound.
std::string fault_of(const Running& run) {
  const Liquid<float>& liquid = run.liquid;
  if (const std::string fault = first_not_finite(liquid); !fault.empty()) return fault;
  const Fluid<float>& fluid = liquid.fluid;
  const float h = fluid.spacing;
  const auto in_box = [&](const Vector3<float>& p) {
    return p.x >= 0 && p.y >= 0 && p.z >= 0 && p.x <= h * fluid.nx && p.y <= h * fluid.ny && p.z <= h * fluid.nz;
  };
  const std::string lost =
      first_fault("particle ", liquid.particles.count, " is outside the box or in an obstacle", [&](int i) {
        const Vector3<float> p = load(liquid.particles.position, i);
        return in_box(p) && !(sample<std::int32_t>(fluid.solid, first_centre, (1 / h) * p) < 0);
      });
  if (!lost.empty()) return lost;
  const std::string lost_drop = first_fault("drop ", liquid.spray.count, " is outside the box",
                                            [&](int i) { return in_box(load(liquid.spray.position, i)); });
  return lost_drop.empty() ? fault_of_volume(run) : lost_drop;
}

Simulation simulation(const RunOptions& options) {
  auto run = std::make_shared<Running>();
  run->scene = load_scene(options.scene);
  run->liquid.fluid = run->scene.fluid;
  serial::start(run->scene.model, run->liquid, run->memory);
  run->volume_at_start = volume_of(run->liquid.fluid);
  const bool is_serial = options.variant == "serial";
  const LiquidForm& form = find_form(liquid_forms, options.form, [](const LiquidForm&) { return true; });
  Step<float>* const take = is_serial ? form.serial : form.openmp;
  Liquid<float>& liquid = run->liquid;
  const float h = liquid.fluid.spacing;
  std::vector<Part> parts = {
      {"frame", true, [run, h](const std::string& path) { write_vtk(path, run->liquid.fluid.phi, 4 * h); }, ".vti"},
      {"particles", true, [run](const std::string& path) { write_vtk(path, run->liquid.particles); }},
      {"spray", true, [run](const std::string& path) { write_vtk(path, run->liquid.spray); }}};
  if (std::ranges::any_of(liquid.fluid.solid.value, is_solid<float>) && run->memory.extension.first.back() > 0)
    parts.push_back({"obstacles", false,
                     [run, h](const std::string& path) { write_vtk(path, run->liquid.fluid.solid, 4 * h); }, ".vti"});
  std::vector<Kept> state = keep_all(liquid);
  state.insert(state.end(), {keep_number(liquid.frames), keep_number(liquid.planned), keep_number(liquid.pushed),
                             keep_number(liquid.particles.count), keep_number(liquid.spray.count),
                             keep_number(run->volume_at_start)});
  return {
      .name = run->scene.name,
      .form = form.name,
      .elements = liquid.fluid.nx * liquid.fluid.ny * liquid.fluid.nz,
      .unit = "cells",
      .frames = run->scene.frames,
      .step = [run, take] { step(*run, take); },
      .time_step = run->scene.model.frame,
      .parts = parts,
      .write_state = nullptr,
      .state_formats = {},
      .state = state,
      .fault = [run] { return fault_of(*run); },
      .summary = [run] { return summary_of(*run); },
  };
}

// A scene that is loaded must have finite values.
std::string fault_of_scene(const std::string& path) { return first_not_finite(load_scene(path).fluid); }

const RegisterDomain production_fluid_domain{{.name = "production_fluid",
                                              .simulation = simulation,
                                              .determinism = {"obstacle_48"},
                                              .endure = {"drop_64", "glass_48"},
                                              .most_steps = 250,  // some nine substeps each
                                              .fault_of_scene = fault_of_scene}};

}  // namespace
}  // namespace lockstep::verify
