// The production cloth: what `run` and `endure` do with its scenes.
#include <cmath>
#include <cstdio>
#include <memory>

#include "common/input_error.h"
#include "common/production_cloth/intersections.h"
#include "common/production_cloth/scene.h"
#include "common/production_cloth/vtk.h"
#include "verify/arrays.h"
#include "verify/domain.h"
#include "verify/production_cloth/forms.h"
#include "verify/production_cloth/moving.h"

namespace lockstep::verify {
namespace {

using namespace production_cloth;

// What the run's steps took, together.
struct Sum {
  double pairs = 0, near = 0, iterations = 0, impacts = 0, rounds = 0, inelastic = 0, zone_rounds = 0, in_zones = 0;
  int cut_off = 0;  // steps

  void add(const Took& took) {
    const Collided& c = took.collided;
    pairs += took.pairs, near += took.near, iterations += took.iterations;
    impacts += c.impacts, rounds += c.rounds, inelastic += c.inelastic_rounds, zone_rounds += c.zone_rounds,
        in_zones += c.zone_vertices;
    cut_off += !c.free;
  }
};

struct Running {
  Scene scene;
  Cloth<float> cloth;
  Motion<float> motion;
  StepMemory<float> memory;
  int frames = 0, steps = 0;
  bool watches = false;  // whether every step is checked
  std::string fault;     // the first that was found
  Sum sum;
  double seconds[int(Module::count)] = {};

  double time() const { return steps * scene.frame_time / scene.substeps; }
};

// Every number is finite, and no triangle passes through another.
std::string fault_of(const Running& run) {
  if (!run.fault.empty()) return run.fault;
  if (const std::string fault = first_not_finite(run.motion, of_element("vertex")); !fault.empty()) return fault;
  const auto found = first_intersection(run.cloth.topology, run.motion.position);
  if (!found) return "";
  return "triangles " + std::to_string((*found)[0] + 1) + " and " + std::to_string((*found)[1] + 1) +
         " intersect after step " + std::to_string(run.steps);
}

void frame(Running& run, Step<float>* step) {
  for (int k = 0; k < run.scene.substeps; ++k) {
    const double start = run.time();
    ++run.steps;
    step(run.cloth, script_of(run.scene, start, run.time()), run.motion, run.memory);
    run.sum.add(run.memory.took);
    if (run.watches) run.fault = fault_of(run);
    for (int m = 0; m < int(Module::count); ++m) run.seconds[m] += run.memory.seconds[m];
  }
  ++run.frames;
}

std::string summary_of(const Running& run) {
  char part[240];
  const double steps = run.steps;
  const Sum& sum = run.sum;
  std::snprintf(part, sizeof part,
                "a step: %.0f pairs, %.1f of them near, %.1f iterations of damping; %.1f impacts, %.2f rounds, "
                "%.2f of inelastic and %.2f of rigid zones with %.1f vertices\n",
                sum.pairs / steps, sum.near / steps, sum.iterations / steps, sum.impacts / steps, sum.rounds / steps,
                sum.inelastic / steps, sum.zone_rounds / steps, sum.in_zones / steps);
  std::string text = part;
  text += std::to_string(sum.cut_off) + " of " + std::to_string(run.steps) + " steps cut off, " +
          std::to_string(count_intersections(run.cloth.topology, run.motion.position)) +
          " intersections in the end\nms a frame:";
  for (int k = 0; k < int(Module::count); ++k) {
    std::snprintf(part, sizeof part, "%s %s %.2f", k ? "," : "", name_of_module[k], 1e3 * run.seconds[k] / run.frames);
    text += part;
  }
  return text;
}

Simulation simulation(const RunOptions& options) {
  auto run = std::make_shared<Running>();
  run->scene = load_scene(options.scene), run->watches = options.watch;
  require_stability(run->scene);
  run->cloth = make_cloth(run->scene);
  run->motion = motion_at_rest(run->scene);
  const bool is_serial = options.variant == "serial";
  run->memory = is_serial ? serial::make_memory(run->cloth) : openmp::make_memory(run->cloth);
  const ProductionClothForm& form =
      find_form(production_cloth_forms, options.form,
                [&](const ProductionClothForm& form) { return is_serial || form.openmp != nullptr; });
  Step<float>* const step = is_serial ? form.serial : form.openmp;
  std::vector<Kept> state = keep_all(run->motion);
  state.push_back(keep_number(run->frames)), state.push_back(keep_number(run->steps));
  std::vector<Part> parts = {
      {"frame", true, [run](const std::string& path) { write_vtk(path, run->cloth.topology, run->motion); }}};
  if (!run->scene.bodies.empty())
    parts.push_back({"obstacles", true, [run](const std::string& path) {
                       write_obstacles(path, run->scene.bodies, run->time(), run->motion.position,
                                       run->cloth.topology.vertices);
                     }});
  return {
      .name = run->scene.name,
      .form = form.name,
      .elements = static_cast<int>(run->cloth.topology.triangles.size()),
      .unit = "triangles",
      .frames = run->scene.frames,
      .step = [run, step] { frame(*run, step); },
      .time_step = run->scene.frame_time,
      .parts = parts,
      .write_state = nullptr,
      .state_formats = {},
      .state = state,
      .fault = [run] { return fault_of(*run); },
      .summary = [run] { return summary_of(*run); },
  };
}

// A cloth that is loaded has finite positions, and triangles whose corners are vertices.
std::string fault_of_scene(const std::string& path) {
  const Scene scene = load_scene(path);
  for (int i = 0; i < scene.topology.vertices; ++i) {
    const Vector3<double> p = load(scene.rest, i);
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) return "a position is not finite";
  }
  for (std::size_t t = 0; t < scene.topology.triangles.size(); ++t)
    for (const std::int32_t v : scene.topology.corners(t))
      if (v < 0 || v >= scene.topology.vertices) return "a corner is no vertex";
  return "";
}

const RegisterDomain production_cloth_domain{{.name = "production_cloth",
                                              .simulation = simulation,
                                              .determinism = {"ball_5k", "tube_5k"},
                                              .endure = {"ball_5k", "tube_5k", "stack_4k", "knot_turns"},
                                              .most_steps = 500,
                                              .fault_of_scene = fault_of_scene}};

}  // namespace
}  // namespace lockstep::verify
