// How `run` and `endure` handle scenes of rigid bodies.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <utility>
#include <vector>

#include "common/rigid/scene.h"
#include "common/rigid/step.h"
#include "common/rigid/vtk.h"
#include "verify/domain.h"
#include "verify/rigid/run.h"

namespace lockstep::verify {
namespace {

bool finite(const Vector3<float>& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

// Makes `steps` steps in which bodies that have a velocity wait. The others come to rest: at the start, bodies that
// touch do not bear one another yet.
void let_rest(int steps, const rigid::StepSettings& settings, rigid::Step<float>* step, rigid::World<float>& world,
              rigid::StepMemory<float>& memory) {
  rigid::Bodies<float>& bodies = world.bodies;
  const Array<rigid::Motion<float>> motion = bodies.motion;
  const Array<rigid::Quad<float>> inverse_mass = bodies.inverse_mass;
  const auto waits = [&](int i) {
    const auto& [velocity, angular_velocity] = std::pair(motion[i].velocity, motion[i].angular_velocity);
    return inverse_mass[i].w > 0 && dot(velocity, velocity) + dot(angular_velocity, angular_velocity) > 0;
  };
  for (int i = 0; i < bodies.count; ++i)
    if (waits(i)) bodies.motion[i] = {}, bodies.inverse_mass[i] = {};
  for (int k = 0; k < steps; ++k) step(settings, world, memory);
  for (int i = 0; i < bodies.count; ++i)
    if (waits(i)) bodies.motion[i] = motion[i], bodies.inverse_mass[i] = inverse_mass[i];
}

Simulation simulation(const RunOptions& options) {
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
                        {"openmp", "original", rigid::openmp::step_original},
                        {"serial", "batches_kept", rigid::serial::step_batches_kept},
                        {"openmp", "batches_kept", rigid::openmp::step_batches_kept},
                        {"serial", "blocks", rigid::serial::step_blocks},
                        {"openmp", "blocks", rigid::openmp::step_blocks}};
  const rigid::Scene scene = rigid::load_scene(options.scene);
  const auto state = std::make_shared<State>(State{scene.world, settings_of(scene), {}, {}, 0});
  const Form form = find_form(forms, options.form, [&](const Form& f) { return f.variant == options.variant; });
  rigid::Bodies<float>& bodies = state->world.bodies;
  rigid::StepMemory<float>& memory = state->memory;
  let_rest(scene.rest, state->settings, form.step, state->world, memory);
  const auto surfaces_of = [&](rigid::Part part) {
    return [state, part](const std::string& path) { rigid::write_surfaces(path, state->world, part); };
  };
  std::vector<Part> parts = {
      {"frame", true, surfaces_of(rigid::Part::moving)},
      {"bodies", true, [state](const std::string& path) { rigid::write_bodies(path, state->world); }}};
  if (has(state->world, rigid::Part::fixed)) parts.push_back({"static", false, surfaces_of(rigid::Part::fixed)});
  if (has(state->world, rigid::Part::planes)) parts.push_back({"ground", false, surfaces_of(rigid::Part::planes)});
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
      .time_step = scene.time_step,
      .parts = parts,
      .write_state = nullptr,
      .state_formats = {},
      .state = {keep(bodies.pose), keep(bodies.motion), keep(memory.manifolds), keep(memory.impulses),
                keep(memory.narrow_phase.pairs), keep(memory.narrow_phase.simplex), keep(memory.kept.pairs),
                keep(memory.kept.contact)},
      .fault =
          [state] {
            const rigid::Bodies<float>& bodies = state->world.bodies;
            const rigid::Colliders<float>& colliders = state->world.colliders;
            std::vector<rigid::Pose<float>> planes;
            for (int k = 0; k < colliders.count; ++k)
              if (colliders.kind[k] == int(rigid::Kind::plane)) planes.push_back(state->memory.placed[k]);
            const auto above_planes = [&](const Vector3<float>& x) {
              return std::ranges::all_of(planes, [&](const auto& plane) {
                return dot(matrix_of(plane.orientation).y, x - plane.position) >= 0;
              });
            };
            return first_fault("body ", bodies.count, " is not finite or below a plane", [&](int i) {
              const Quaternion<float>& q = bodies.pose[i].orientation;
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
              std::snprintf(part, sizeof part, "%s %.2f, ", rigid::phase_names[phase],
                            1e3 * state->seconds[phase] / state->steps);
              text += part;
            }
            double deepest = 0;
            int points = 0;
            for (const rigid::Manifold<float>& m : state->memory.manifolds) {
              points += m.count;
              for (int k = 0; k < m.count; ++k) deepest = std::max(deepest, -double(m.point[k].separation));
            }
            std::snprintf(part, sizeof part, "%zu contacts, %d points, deepest %.2f mm", state->memory.manifolds.size(),
                          points, 1e3 * deepest);
            return "ms a step: " + text + part;
          },
  };
}

bool is_unit(const Quaternion<float>& q) { return std::abs(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w - 1) < 1e-5f; }

// A loaded scene must have finite numbers, orientations of length 1, no negative mass, and only hulls that exist.
std::string fault_of_scene(const std::string& path) {
  const rigid::Scene scene = rigid::load_scene(path);
  const auto& [bodies, colliders, hulls] = scene.world;
  for (int i = 0; i < bodies.count; ++i) {
    const std::string body = "body " + std::to_string(i);
    const auto& [x, y, z, mass] = bodies.inverse_mass[i];
    if (!finite(bodies.pose[i].position) || !finite(bodies.motion[i].velocity) ||
        !finite(bodies.motion[i].angular_velocity))
      return body + " is not finite";
    if (!is_unit(bodies.pose[i].orientation)) return "the orientation of " + body + " is not of length 1";
    if (!finite({x, y, z}) || !(x >= 0 && y >= 0 && z >= 0 && mass >= 0) || !std::isfinite(mass))
      return "an inverse mass of " + body + " is negative or not finite";
  }
  for (int i = 0; i < colliders.count; ++i) {
    const std::string collider = "collider " + std::to_string(i);
    if (!finite(colliders.local[i].position)) return collider + " is not finite";
    if (!is_unit(colliders.local[i].orientation)) return "the orientation of " + collider + " is not of length 1";
    if (colliders.hull[i] >= hulls.count) return collider + " has a hull that is not there";
  }
  for (const auto& [x, y, z, w] : hulls.vertex)
    if (!finite({x, y, z})) return "a vertex is not finite";
  for (const auto& [x, y, z, w] : hulls.plane)
    if (!finite({x, y, z}) || !std::isfinite(w)) return "a plane is not finite";
  return "";
}

const RegisterDomain rigid_domain{
    {.name = "rigid", .simulation = simulation, .determinism = {"mesh_and_hulls"}, .fault_of_scene = fault_of_scene}};

}  // namespace
}  // namespace lockstep::verify
