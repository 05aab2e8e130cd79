#include "verify/simulation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <vector>

#include "common/cloth/make.h"
#include "common/cloth/scene.h"
#include "common/cloth/vtk.h"
#include "common/fluid/densities.h"
#include "common/fluid/file.h"
#include "common/fluid/rebuild_grid.h"
#include "common/fluid/scene.h"
#include "common/fluid/vtk.h"
#include "common/input_error.h"
#include "common/levelset/blocks.h"
#include "common/levelset/fast_marching.h"
#include "common/levelset/fast_sweeping.h"
#include "common/levelset/initialize.h"
#include "common/levelset/scene.h"
#include "common/levelset/vti.h"
#include "common/rigid/scene.h"
#include "common/rigid/step.h"
#include "common/rigid/vtk.h"
#include "common/scene.h"
#include "verify/cloth_forms.h"
#include "verify/fluid_forms.h"
#include "verify/rigid_run.h"

namespace lockstep::verify {
namespace {

// The first form that fits, or the one asked for.
template <class Forms, class Fits>
const auto& find_form(const Forms& forms, const std::string& asked, Fits fits) {
  std::string known;
  for (const auto& form : forms) {
    if (!fits(form)) continue;
    if (asked.empty() || asked == form.name) return form;
    known += (known.empty() ? "" : ", ") + form.name;
  }
  throw InputError("--form " + asked + ": expected one of: " + known);
}

// The first of n elements that is not as it should be, "" if all are.
template <class Fits>
std::string first_fault(const char* what, int n, const char* fault, Fits fits) {
  for (int i = 0; i < n; ++i)
    if (!fits(i)) return what + std::to_string(i) + fault;
  return "";
}

bool finite(const Vector3<float>& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

}  // namespace

Simulation make_simulation(const RunOptions& options) {
  const std::string kind = kind_of_scene(options.scene);
  if (kind == "cloth") return cloth_simulation(options);
  if (kind == "levelset") return levelset_simulation(options);
  if (kind == "rigid") return rigid_simulation(options);
  return fluid_simulation(options);
}

Simulation fluid_simulation(const RunOptions& options) {
  fluid::Scene scene = fluid::load_scene(options.scene);
  const StepForm& form = find_form(step_forms, options.form, [&](const StepForm& f) { return f.variant == options.variant; });
  auto state = std::make_shared<fluid::Fluid<float>>(fluid::make_fluid(fluid::convert<float>(scene.model), std::move(scene.particles)));
  auto is_start = std::make_shared<bool>(true);
  fluid::Particles<float>& p = state->particles;
  return {
      .name = scene.name,
      .form = form.name,
      .elements = p.count,
      .unit = "particles",
      .frames = scene.frames,
      .step = [state, is_start, form] { form.step(*state), *is_start = false; },
      .write_frame =
          [state, is_start](const std::string& path) {
            // The densities of the start, for ParaView's colours, are the one thing it does not have yet.
            if (*is_start) {
              fluid::serial::rebuild_grid(state->grid, state->particles, state->sorted);
              fluid::serial::densities_symmetric(state->model, state->grid, state->particles, state->neighbours, state->density);
            }
            fluid::write_vtk(path, state->particles, {state->density.data(), std::size_t(state->particles.count)});
          },
      .write_state = [state, per_metre = static_cast<float>(scene.model.particles_per_metre)](
                         const std::string& path) { fluid::write_fluid(path, per_metre, state->particles); },
      .state_formats = {".fluid"},
      .state = {keep(p.id), keep(p.position.x), keep(p.position.y), keep(p.position.z), keep(p.half_velocity.x), keep(p.half_velocity.y),
                keep(p.half_velocity.z), keep(p.velocity.x), keep(p.velocity.y), keep(p.velocity.z)},
      .fault =
          [state] {
            const fluid::Model<float>& model = state->model;
            const fluid::Particles<float>& p = state->particles;
            // Walls push back, from the step after the one in which a particle came through: it is out by no more than what they give way
            // and what it moves in a step.
            const auto within = [&](float x, float least, float most, float give) { return x >= least - give && x <= most + give; };
            return first_fault("particle ", p.count, " is no number or through a wall", [&](int i) {
              const Vectors<float>&x = p.position, &v = p.velocity, &half = p.half_velocity;
              const Vector3<float> move = model.time_step * Vector3<float>{half.x[i], half.y[i], half.z[i]};
              const float give = model.walls ? model.smoothing_length + std::sqrt(dot(move, move)) : std::numeric_limits<float>::max();
              return within(x.x[i], model.domain_min.x, model.domain_max.x, give) &&
                     within(x.y[i], model.domain_min.y, model.domain_max.y, give) &&
                     within(x.z[i], model.domain_min.z, model.domain_max.z, give) && finite(move) && finite({v.x[i], v.y[i], v.z[i]});
            });
          },
      .summary = nullptr,
  };
}

Simulation cloth_simulation(const RunOptions& options) {
  const cloth::Scene scene = cloth::load_scene(options.scene);
  auto state = std::make_shared<cloth::Cloth<float>>(cloth::convert<float>(scene.cloth));
  const bool serial = options.variant == "serial", is_sheet = state->sheet.rows > 0;
  const ClothForm& form = find_form(cloth_forms, options.form, [&](const ClothForm& f) {
    return (f.for_meshes || is_sheet) && (serial ? f.serial_step : f.openmp_step);
  });
  cloth::Step<float>* const step = serial ? form.serial_step : form.openmp_step;
  Vectors<float>&x = state->position, &before = state->previous;
  return {
      .name = scene.name,
      .form = form.name,
      .elements = is_sheet ? state->sheet.rows * state->sheet.columns : state->count,
      .unit = "particles",
      .frames = scene.frames,
      .step = [state, step] { step(*state); },
      .write_frame = [state](const std::string& path) { cloth::write_vtk(path, *state); },
      .write_state = nullptr,
      .state_formats = {},
      .state = {keep(x.x), keep(x.y), keep(x.z), keep(before.x), keep(before.y), keep(before.z)},
      .fault =
          [state] {
            const Array<float>&x = state->position.x, &y = state->position.y, &z = state->position.z;
            return first_fault("particle ", state->count, " is no number", [&](int i) { return finite({x[i], y[i], z[i]}); });
          },
      .summary = nullptr,
  };
}

// A level set does not move: one step makes the distances.
Simulation levelset_simulation(const RunOptions& options) {
  struct State {
    levelset::Scene scene;
    levelset::Field<float> signed_distance;
  };
  using Compute = std::function<void(levelset::Distances<float>&, float band, int rounds)>;
  struct Form {
    std::string variant, name;
    levelset::Initialize<float>* initialize;
    Compute compute;
  };
  const auto march = [](levelset::FastMarching<float>* marching) -> Compute {
    return [marching](levelset::Distances<float>& d, float band, int) { marching(d, band); };
  };
  namespace serial = levelset::serial;
  namespace openmp = levelset::openmp;
  const auto sweep = [](levelset::FastSweeping<float>* sweeping) -> Compute { return sweeping; };
  const auto sweep_blocks = [](levelset::FastSweepingInBlocks<float>* sweeping) -> Compute {
    return [sweeping](levelset::Distances<float>& d, float band, int rounds) { sweeping(d, band, rounds, levelset::block_size); };
  };
  const Form forms[] = {{"serial", "sweeps", serial::initialize, sweep(serial::fast_sweeping_sweeps)},
                        {"serial", "blocks", serial::initialize, sweep_blocks(serial::fast_sweeping_blocks)},
                        {"serial", "heap", serial::initialize, march(serial::fast_marching_heap)},
                        {"openmp", "sweeps", openmp::initialize, sweep(openmp::fast_sweeping_sweeps)},
                        {"openmp", "blocks", openmp::initialize, sweep_blocks(openmp::fast_sweeping_blocks)}};

  auto state = std::make_shared<State>(State{levelset::load_scene(options.scene), {}});
  state->signed_distance = state->scene.phi;
  const Form form = find_form(forms, options.form, [&](const Form& f) { return f.variant == options.variant; });
  const auto write = [state](const std::string& path) {
    levelset::write_image(path, state->signed_distance, state->scene.grid, static_cast<float>(state->scene.band));
  };
  const levelset::Grid& grid = state->scene.grid;
  return {
      .name = state->scene.name,
      .form = form.name,
      .elements = grid.nx * grid.ny * grid.nz,
      .unit = "points",
      .frames = 1,
      .step =
          [state, form] {
            levelset::Distances<float> distances;
            form.initialize(state->scene.phi, distances);
            form.compute(distances, static_cast<float>(state->scene.band), state->scene.rounds);
            const Array<float>&phi = state->scene.phi.value, &d = distances.distance.value;
            for (std::size_t i = 0; i < d.size(); ++i) state->signed_distance.value[i] = phi[i] < 0 ? -d[i] : d[i];
          },
      .write_frame = write,
      .write_state = write,
      .state_formats = {".vti", ".vtk"},
      .state = {},
      .fault =
          [state] {
            const Array<float>& d = state->signed_distance.value;
            return first_fault("point ", static_cast<int>(d.size()), " is no number", [&](int i) { return !std::isnan(d[i]); });
          },
      .summary = nullptr,
  };
}

Simulation rigid_simulation(const RunOptions& options) {
  struct State {
    rigid::World<float> world;
    rigid::StepSettings settings;
    rigid::StepMemory<float> memory;
    std::array<double, rigid::phases> seconds = {};
    int steps = 0;
  };
  struct Form {
    std::string variant, name;
    rigid::Step<float>* step;
  };
  const Form forms[] = {{"serial", "original", rigid::serial::step_original},
                        {"serial", "batches", rigid::serial::step_batches},
                        {"openmp", "batches", rigid::openmp::step_batches},
                        {"openmp", "original", rigid::openmp::step_original}};
  const rigid::Scene scene = rigid::load_scene(options.scene);
  const auto state = std::make_shared<State>(State{scene.world, settings_of(scene), {}, {}, 0});
  const Form form = find_form(forms, options.form, [&](const Form& f) { return f.variant == options.variant; });
  rigid::Bodies<float>& bodies = state->world.bodies;
  rigid::StepMemory<float>& memory = state->memory;
  return {
      .name = scene.name,
      .form = form.name,
      .elements = bodies.count,
      .unit = "bodies",
      .frames = scene.frames,
      .step =
          [state, form] {
            form.step(state->settings, state->world, state->memory);
            for (int phase = 0; phase < rigid::phases; ++phase) state->seconds[phase] += state->memory.seconds[phase];
            ++state->steps;
          },
      .write_frame = [state](const std::string& path) { rigid::write_vtk(path, state->world); },
      .write_state = nullptr,
      .state_formats = {},
      .state = {keep(bodies.pose), keep(bodies.motion), keep(memory.manifolds), keep(memory.impulses), keep(memory.narrow_phase.pairs),
                keep(memory.narrow_phase.simplex)},
      .fault =
          [state] {
            const rigid::Bodies<float>& bodies = state->world.bodies;
            const rigid::Colliders<float>& colliders = state->world.colliders;
            std::vector<rigid::Pose<float>> planes;
            for (int k = 0; k < colliders.count; ++k)
              if (colliders.kind[k] == int(rigid::Kind::plane)) planes.push_back(state->memory.placed[k]);
            const auto above_planes = [&](const Vector3<float>& x) {
              return std::ranges::all_of(planes,
                                         [&](const auto& plane) { return dot(matrix_of(plane.orientation).y, x - plane.position) >= 0; });
            };
            return first_fault("body ", bodies.count, " is no number or below a plane", [&](int i) {
              const rigid::Quaternion<float>& q = bodies.pose[i].orientation;
              return finite(bodies.pose[i].position) && finite({q.x, q.y, q.z}) && std::isfinite(q.w) &&
                     finite(bodies.motion[i].velocity) && finite(bodies.motion[i].angular_velocity) &&
                     (bodies.inverse_mass[i].w == 0 || above_planes(bodies.pose[i].position));
            });
          },
      .summary =
          [state] {
            std::string text;
            char part[64];
            for (int phase = 0; phase < rigid::phases; ++phase) {
              std::snprintf(part, sizeof part, "%s %.2f, ", rigid::phase_names[phase], 1e3 * state->seconds[phase] / state->steps);
              text += part;
            }
            double deepest = 0;
            int points = 0;
            for (const rigid::Manifold<float>& m : state->memory.manifolds) {
              points += m.count;
              for (int k = 0; k < m.count; ++k) deepest = std::max(deepest, -double(m.point[k].separation));
            }
            std::snprintf(part, sizeof part, "%zu contacts, %d points, deepest %.2f mm", state->memory.manifolds.size(), points,
                          1e3 * deepest);
            return "ms a step: " + text + part;
          },
  };
}

}  // namespace lockstep::verify
