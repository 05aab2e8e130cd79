#include "verify/production_cloth/moving.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/convert.h"
#include "common/input_error.h"
#include "common/production_cloth/masses.h"
#include "common/production_cloth/repulsions.h"
#include "verify/inputs.h"
#include "verify/production_cloth/inputs.h"

namespace lockstep::production_cloth {

// For the cache.
double bytes_of(const MovingInputs& in) { return 1000. * static_cast<double>(in.cloth.topology.triangles.size()); }

}  // namespace lockstep::production_cloth

namespace lockstep::verify {

using namespace production_cloth;

// Of the serial step, in search of the motion that moving.h describes.
constexpr int most_steps = 100;

Cloth<float> make_cloth(const Scene& scene) {
  Cloth<float> cloth = {.topology = scene.topology,
                        .elements = make_elements<float>(scene.topology, scene.rest, scene.material),
                        .search = make_search(scene.topology),
                        .near_at_rest = {},
                        .mass = convert<float>(lumped_masses(scene.topology, scene.rest, scene.material.density)),
                        .inverse_mass = production_cloth_inputs::inverse_masses(scene),
                        .contact = scene.contact,
                        .gravity = convert<float>(scene.gravity),
                        .time_step = static_cast<float>(scene.frame_time / scene.substeps),
                        .stop = {.tolerance = scene.tolerance, .iterations = scene.iterations}};
  const double near = neighbours_within * scene.contact.thickness;
  cloth.near_at_rest = rest_neighbours(
      scene.topology, production_cloth_inputs::pairs_within(scene.topology, scene.rest, scene.rest, .5 * near),
      scene.rest, near);
  return cloth;
}

Motion<float> motion_at_rest(const Scene& scene) {
  const int n = scene.topology.vertices;
  Motion<float> motion = {convert<float>(scene.rest), {}, make_changes<float>(n), make_changes<float>(n)};
  motion.velocity.resize(n);
  return motion;
}

double highest_frequency(const Scene& scene) {
  const int n = scene.topology.vertices;
  const auto elements = make_elements<double>(scene.topology, scene.rest, scene.material);
  const Array<double> mass = lumped_masses(scene.topology, scene.rest, scene.material.density);
  const Array<float> inverse_mass = production_cloth_inputs::inverse_masses(scene);
  auto state = serial::make_state(elements);
  Vectors<double> direction, displaced = scene.rest, force, at_rest;
  for (Vectors<double>* v : {&direction, &force, &at_rest}) v->resize(n);
  serial::forces(elements, scene.rest, state, at_rest);
  // A start that is orthogonal to no mode, in all likelihood.
  for (int i = 0; i < n; ++i) store(direction, i, {std::sin(1. * i * i), std::sin(2. + i * i), std::sin(4. + i * i)});
  double shortest = std::numeric_limits<double>::infinity();  // edge, squared
  for (const auto& [a, b] : scene.topology.edges) {
    const Vector3<double> along = load(scene.rest, b) - load(scene.rest, a);
    shortest = std::min(shortest, dot(along, along));
  }
  double square = 0;
  for (int round = 0; round < 40; ++round) {
    double norm = 0, longest = 0, norm_of_next = 0;
    for (int i = 0; i < n; ++i) {
      const double length = dot(load(direction, i), load(direction, i));
      norm += mass[i] * length, longest = std::max(longest, length);
    }
    if (!(norm > 0)) return 0;
    // A difference over a millionth of an edge stands for the derivative.
    const double step = 1e-6 * std::sqrt(shortest / longest);
    for (int i = 0; i < n; ++i) store(displaced, i, load(scene.rest, i) + step * load(direction, i));
    serial::forces(elements, displaced, state, force);
    for (int i = 0; i < n; ++i) {
      const Vector3<double> next = (inverse_mass[i] / (step * std::sqrt(norm))) * (load(at_rest, i) - load(force, i));
      norm_of_next += mass[i] * dot(next, next);
      store(direction, i, next);
    }
    square = std::sqrt(norm_of_next);
  }
  return std::sqrt(square);
}

void require_stability(const Scene& scene) {
  const double frequency = highest_frequency(scene), time_step = scene.frame_time / scene.substeps;
  if (!(time_step * frequency > 2)) return;
  throw InputError(scene.path + ": a step of " + std::to_string(time_step) +
                   " s is unstable: springs of this stiffness and mass swing up to " + std::to_string(frequency) +
                   " rad/s; expected substeps of at least " +
                   std::to_string(static_cast<long long>(std::ceil(scene.frame_time * frequency / 2))));
}

namespace production_cloth_inputs {

std::shared_ptr<const MovingInputs> moving_inputs(const std::string& path) {
  return lockstep::verify::inputs<MovingInputs>(path, [&] {
    const auto scene = inputs(path);
    MovingInputs in = {make_cloth(*scene), motion_at_rest(*scene), {}};
    StepMemory<float> memory = serial::make_memory(in.cloth);
    const double dt = scene->frame_time / scene->substeps;
    Motion<float> motion = in.motion;
    bool were_near = false, has_met = false;
    for (int k = 0; k < most_steps && memory.took.collided.zone_vertices == 0; ++k) {
      const Motion<float> before = motion;
      const Script<float> script = script_of(*scene, k * dt, (k + 1) * dt);
      serial::step_original(in.cloth, script, motion, memory);
      const bool are_near = memory.took.near > 0, meets = memory.took.collided.impacts > 0 || (are_near && !were_near);
      if (meets || !has_met) in.motion = before, in.script = script;
      were_near |= are_near, has_met |= meets;
    }
    return in;
  });
}

Scenes moving_scenes() {
  return {
      .verify = {"two_triangles", "crumple", "wrung_tube", "wrung_tube_slides", "ball_and_walls", "ball_5k", "tube_5k"},
      .more = {"ball_92k"},
      .bench = {"curtain_and_ball_5k", "curtain_and_ball_55k", "ball_92k"},
      .tsan = {"crumple", "wrung_tube"}};
}

}  // namespace production_cloth_inputs
}  // namespace lockstep::verify
