// The production face: what `run` and `endure` do with its scenes.
#include <cmath>
#include <cstdio>
#include <memory>

#include "common/production_face/element.h"
#include "common/production_face/scene.h"
#include "common/production_face/vtk.h"
#include "verify/arrays.h"
#include "verify/domain.h"
#include "verify/production_face/forms.h"

namespace lockstep::verify {
namespace {

using namespace production_face;

struct Running {
  Scene scene;
  Face<float> face;
  Pose<float> pose;
  SerialMemory rows;
  OpenmpMemory slices;
  Frame frame;  // the last one
  int frames = 0, steps = 0, iterations = 0;
  std::string fault;  // the first of a frame; "" if none
  double seconds[int(Module::count)] = {};
};

std::string fault_of(const Running& run);

void step(Running& run, const FaceForm& form, bool is_serial) {
  const Target<float> target = target_at(run.scene.body, run.scene.motion, (run.frames + 1) * frame_time);
  if (is_serial)
    form.serial(run.face, target, run.scene.tolerance, run.pose, run.rows);
  else
    form.openmp(run.face, target, run.scene.tolerance, run.pose, run.slices);
  run.frame = is_serial ? run.rows.frame : run.slices.frame;
  ++run.frames, run.steps += run.frame.steps, run.iterations += run.frame.iterations;
  for (int k = 0; k < int(Module::count); ++k) run.seconds[k] += run.frame.seconds[k];
  if (run.fault.empty())
    if (const std::string fault = fault_of(run); !fault.empty())
      run.fault = "frame " + std::to_string(run.frames) + ": " + fault;
}

// The least volume of a tetrahedron over that at rest.
double least_volume(const Running& run) {
  const Body<float>& body = run.scene.body;
  double least = 1;
  for (int t = 0; t < body.tetrahedra; ++t) {
    Vector3<float> u[4], gradient[3];
    for (int a = 0; a < 4; ++a) u[a] = load(run.pose.displacement, body.corner.at(t, a));
    for (int a = 0; a < 3; ++a)
      gradient[a] = {body.gradient.at(t, 3 * a), body.gradient.at(t, 3 * a + 1), body.gradient.at(t, 3 * a + 2)};
    const Matrix3<float> f = deformation(u, gradient);
    least = std::min(least, double(dot(f.x, cross(f.y, f.z))));
  }
  return least;
}

std::string summary_of(const Running& run) {
  char part[200];
  std::snprintf(
      part, sizeof part,
      "a frame: %.1f steps of Newton's method, %.0f iterations\nthe last: |f| %.2e of %.2e N; least volume of a "
      "tetrahedron %.3f of its own\nms a frame:",
      double(run.steps) / run.frames, double(run.iterations) / run.frames, run.frame.last, run.frame.first,
      least_volume(run));
  std::string text = part;
  for (int k = 0; k < int(Module::count); ++k) {
    std::snprintf(part, sizeof part, "%s %s %.2f", k ? "," : "", name_of_module[k], 1e3 * run.seconds[k] / run.frames);
    text += part;
  }
  return text;
}

// Every displacement is finite, and no tetrahedron inside out.
std::string fault_of(const Running& run) {
  if (const std::string fault = first_not_finite(run.pose, of_element("node")); !fault.empty()) return fault;
  return least_volume(run) > 0 ? "" : "a tetrahedron is inside out";
}

Simulation simulation(const RunOptions& options) {
  auto run = std::make_shared<Running>();
  run->scene = load_scene(options.scene);
  if (run->scene.turned > 0)
    std::fprintf(stderr, "lockstep: %d tetrahedra were inside out in the file: two of their corners are swapped\n",
                 run->scene.turned);
  if (run->scene.doubled > 0)
    std::fprintf(stderr, "lockstep: %d nodes of the file stand where another does: the mesh is cut between them\n",
                 run->scene.doubled);
  run->face = make_face(run->scene.body, run->scene.flesh);
  run->pose = run->scene.pose;
  const bool is_serial = options.variant == "serial";
  if (is_serial)
    run->rows = serial::make_memory(run->face);
  else
    run->slices = openmp::make_memory(run->face);
  const FaceForm& form = find_form(face_forms, options.form, [](const FaceForm&) { return true; });
  std::vector<Kept> state = keep_all(run->pose);
  state.push_back(keep_number(run->frames));
  return {
      .name = run->scene.name,
      .form = form.name,
      .elements = run->scene.body.tetrahedra,
      .unit = "tetrahedra",
      .frames = run->scene.frames,
      .step = [run, &form, is_serial] { step(*run, form, is_serial); },
      .time_step = frame_time,
      .parts = {{"frame", true, [run](const std::string& path) { write_vtk(path, run->scene.body, run->pose); }}},
      .write_state = nullptr,
      .state_formats = {},
      .state = state,
      .fault = [run] { return run->fault; },
      .summary = [run] { return summary_of(*run); },
  };
}

// A body that is loaded must have finite gradients and volumes, and corners that are nodes.
std::string fault_of_scene(const std::string& path) {
  const Body<float> body = load_scene(path).body;
  for (int t = 0; t < body.tetrahedra; ++t) {
    if (!(body.volume.at(t, 0) > 0) || !std::isfinite(body.volume.at(t, 0))) return "a volume is not positive";
    for (int k = 0; k < 9; ++k)
      if (!std::isfinite(body.gradient.at(t, k))) return "a gradient is not finite";
    for (int a = 0; a < 4; ++a)
      if (body.corner.at(t, a) < 0 || body.corner.at(t, a) >= body.nodes) return "a corner is no node";
  }
  return "";
}

const RegisterDomain production_face_domain{{.name = "production_face",
                                             .simulation = simulation,
                                             .determinism = {"bar_shaken", "bar_turns"},
                                             .endure = {"bar_pulls", "face_6k"},
                                             .most_steps = 500,
                                             .fault_of_scene = fault_of_scene}};

}  // namespace
}  // namespace lockstep::verify
