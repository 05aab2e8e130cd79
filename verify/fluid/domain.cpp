// The game fluid: what `run` and `endure` do with its scenes.
#include <cmath>
#include <limits>
#include <memory>

#include "common/fluid/densities.h"
#include "common/fluid/file.h"
#include "common/fluid/rebuild_grid.h"
#include "common/fluid/scene.h"
#include "common/fluid/vtk.h"
#include "verify/arrays.h"
#include "verify/domain.h"
#include "verify/fluid/forms.h"

namespace lockstep::verify {
namespace {

bool finite(const Vector3<float>& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

Simulation simulation(const RunOptions& options) {
  fluid::Scene scene = fluid::load_scene(options.scene);
  const StepForm& form =
      find_form(step_forms, options.form, [&](const StepForm& f) { return f.variant == options.variant; });
  auto state = std::make_shared<fluid::Fluid<float>>(
      fluid::make_fluid(fluid::convert<float>(scene.model), std::move(scene.particles)));
  auto is_start = std::make_shared<bool>(true);
  const fluid::Particles<float>& p = state->particles;
  const auto write_particles = [state, is_start](const std::string& path) {
    // The densities of the start, for ParaView's colours, are the one thing it does not have yet.
    if (*is_start) {
      fluid::serial::rebuild_grid(state->grid, state->particles, state->sorted);
      fluid::serial::densities_symmetric(state->model, state->grid, state->particles, state->neighbours,
                                         state->density);
    }
    fluid::write_vtk(path, state->particles, {state->density.data(), std::size_t(state->particles.count)});
  };
  std::vector<Part> parts = {{"frame", true, write_particles}};
  if (state->model.walls)
    parts.push_back({"box", false, [state](const std::string& path) { fluid::write_box(path, state->model); }});
  return {
      .name = scene.name,
      .form = form.name,
      .elements = p.count,
      .unit = "particles",
      .frames = scene.frames,
      .step = [state, is_start, form] { form.step(*state), *is_start = false; },
      .time_step = scene.model.time_step,
      .parts = parts,
      .write_state = [state, per_metre = static_cast<float>(scene.model.particles_per_metre)](
                         const std::string& path) { fluid::write_fluid(path, per_metre, state->particles); },
      .state_formats = {".fluid"},
      .state = keep_all(*state),
      .fault =
          [state] {
            const fluid::Model<float>& model = state->model;
            const fluid::Particles<float>& p = state->particles;
            // Walls push back, from the step after the one in which a particle came through: it is out by no more than
            // what they give way and what it moves in a step.
            const auto within = [&](float x, float least, float most, float give) {
              return x >= least - give && x <= most + give;
            };
            return first_fault("particle ", p.count, " is not finite or through a wall", [&](int i) {
              const Vectors<float>&x = p.position, &v = p.velocity, &half = p.half_velocity;
              const Vector3<float> move = model.time_step * Vector3<float>{half.x[i], half.y[i], half.z[i]};
              const float give =
                  model.walls ? model.smoothing_length + std::sqrt(dot(move, move)) : std::numeric_limits<float>::max();
              return within(x.x[i], model.domain_min.x, model.domain_max.x, give) &&
                     within(x.y[i], model.domain_min.y, model.domain_max.y, give) &&
                     within(x.z[i], model.domain_min.z, model.domain_max.z, give) && finite(move) &&
                     finite({v.x[i], v.y[i], v.z[i]});
            });
          },
      .summary = nullptr,
  };
}

// A scene that is loaded must have finite positions and velocities.
std::string fault_of_scene(const std::string& path) {
  const fluid::Scene scene = fluid::load_scene(path);
  const fluid::Particles<float>& p = scene.particles;
  for (int i = 0; i < p.count; ++i)
    for (const Vectors<float>* v : {&p.position, &p.velocity})
      if (!finite({v->x[i], v->y[i], v->z[i]})) return "particle " + std::to_string(i) + " is not finite";
  return "";
}

const RegisterDomain fluid_domain{{.name = "fluid",
                                   .simulation = simulation,
                                   .determinism = {"dam_break_5k"},
                                   .formats = {".fluid"},
                                   .fault_of_scene = fault_of_scene}};

}  // namespace
}  // namespace lockstep::verify
