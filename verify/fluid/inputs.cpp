#include "verify/fluid/inputs.h"

#include <algorithm>
#include <cstdio>

#include "common/fluid/convert.h"
#include "common/fluid/densities.h"
#include "common/fluid/forces.h"
#include "common/fluid/limits.h"
#include "common/fluid/rebuild_grid.h"
#include "common/fluid/step.h"
#include "verify/fluid/bounds.h"
#include "verify/inputs.h"

namespace lockstep::verify::fluid_inputs {

using namespace fluid;

namespace {

// Frames before kernels are compared: particles have left their lattice and meet walls; or what was shot is still under
// way, and some of it beyond a wall: splash hits one in its 12th frame and one in its 13th, at up to two cells and more
// a frame.
constexpr int settling_frames = 40, frames_of_a_shot = 13;

int frames_before(const Scene& scene) {
  if (scene.holds.lattice_density) return 0;  // a lattice stays one, so that its analytic density can be asked for
  const Vectors<float>& v = scene.particles.velocity;
  for (int i = 0; i < scene.particles.count; ++i)
    if (v.x[i] != 0 || v.y[i] != 0 || v.z[i] != 0) return frames_of_a_shot;
  return settling_frames;
}

void count_pairs(Inputs& in) {
  const Grid<float>& grid = in.fluid.grid;
  const Vectors<float>& p = in.fluid.particles.position;
  for (int z = 0; z < grid.z.cells; ++z)
    for (int y = 0; y < grid.y.cells; ++y)
      for (int x = 0; x < grid.x.cells; ++x) {
        const Run own = row_run(grid, x, x, y, z);
        for (int i = own.begin; i < own.end; ++i)
          for (const Run& run : forward_runs(grid, x, y, z))
            for (int j = std::max(run.begin, i + 1); j < run.end; ++j) {
              const Vector3<float> dp = at(p, i) - at(p, j);
              in.tested_pairs += 1;
              in.near_pairs += dot(dp, dp) < in.fluid.model.smoothing_length_2;
            }
      }
}

Inputs make(const std::string& path) {
  Inputs in;
  in.scene = load_scene(path);
  in.fluid = make_fluid(fluid::convert<float>(in.scene.model), in.scene.particles);
  Fluid<float>& f = in.fluid;
  in.frames_before = frames_before(in.scene);
  for (int frame = 0; frame < in.frames_before; ++frame) serial::step_symmetric(f);
  in.unsorted = f.particles;
  serial::rebuild_grid(f.grid, f.particles, f.sorted);
  serial::densities_owner_gather(f.model, f.grid, f.particles, f.neighbours, f.density);
  serial::forces_symmetric(f.model, f.grid, f.particles, f.neighbours, f.density, f.acceleration);
  in.truth = convert<double>(f);
  Fluid<double> truth = in.truth;
  serial::densities_symmetric(truth.model, truth.grid, truth.particles, truth.neighbours, truth.density);
  in.true_density.assign(truth.density.begin(), truth.density.begin() + f.particles.count);
  in.density_rounding = density_rounding(in.truth, in.true_density);
  count_pairs(in);
  return in;
}

}  // namespace

// For the cache: two fluids and the particles twice more, the lists of one, and two numbers a particle.
double bytes_of(const Inputs& in) {
  const double n = in.fluid.particles.count, cells = in.fluid.grid.cells();
  return simulation_bytes<float>(n, cells) + simulation_bytes<double>(n, cells) + 2 * particle_bytes * n +
         2 * in.near_pairs * sizeof(std::int32_t) + 2 * sizeof(double) * n;
}

std::shared_ptr<const Inputs> inputs(const std::string& path) {
  return verify::inputs<Inputs>(path, [&] { return make(path); });
}

ElementName particle_name(const Inputs& in, const std::string& what) {
  return [&in, what](std::size_t i) {
    const auto& p = in.fluid.particles;
    char text[160];
    std::snprintf(text, sizeof text, "%s of particle %d at (%.4g %.4g %.4g)", what.c_str(), p.id[i], p.position.x[i],
                  p.position.y[i], p.position.z[i]);
    return std::string(text);
  };
}

ValueName particle_value_name(const Inputs& in) {
  return [&in](const std::string& array, std::size_t i, const std::string& field) {
    return particle_name(in, array + (field.empty() ? "" : "." + field))(i);
  };
}

Scenes scenes_with(std::vector<std::string> bench) {
  return {
      .verify = {"dam_break_5k", "lattice_5k", "splash", "clump", "single", "adrift", "lattice_35k", "dam_break_100k"},
      .more = {"water_5k", "water_35k", "dam_break_35k", "lattice_100k", "dam_break_500k", "lattice_500k"},
      .bench = std::move(bench),
      .tsan = {"dam_break_5k", "clump"}};
}

}  // namespace lockstep::verify::fluid_inputs
