#include "verify/rigid/run.h"

#include <algorithm>
#include <cmath>

#include "common/rigid/make.h"
#include "verify/compare.h"

namespace lockstep::verify {
namespace {

using namespace rigid;

Array<Impulses<double>> widened(std::span<const Impulses<float>> impulses) {
  Array<Impulses<double>> wide(impulses.size());
  for (std::size_t i = 0; i < impulses.size(); ++i)
    for (int k = 0; k < most_points; ++k) {
      wide[i].normal[k] = impulses[i].normal[k];
      wide[i].tangent[k] = impulses[i].tangent[k];
      wide[i].bitangent[k] = impulses[i].bitangent[k];
    }
  return wide;
}

Vector3<double> wide(const Vector3<float>& v) { return {v.x, v.y, v.z}; }

Array<Manifold<double>> widened(std::span<const Manifold<float>> manifolds) {
  Array<Manifold<double>> to(manifolds.size());
  for (std::size_t i = 0; i < manifolds.size(); ++i) {
    const Manifold<float>& m = manifolds[i];
    to[i] = {.normal = wide(m.normal),
             .count = m.count,
             .a = m.a,
             .b = m.b,
             .unused = {},
             .point = {},
             .feature = {},
             .more_unused = {}};
    for (int k = 0; k < m.count; ++k) to[i].point[k] = {wide(m.point[k].position), m.point[k].separation};
  }
  return to;
}

std::vector<float> state_of(const Bodies<float>& bodies) {
  std::vector<float> state;
  for (int i = 0; i < bodies.count; ++i) {
    const auto& [position, q, unused] = bodies.pose[i];
    const Motion<float>& motion = bodies.motion[i];
    for (const Vector3<float>& v : {position, motion.velocity, motion.angular_velocity})
      state.insert(state.end(), {v.x, v.y, v.z});
    state.insert(state.end(), {q.x, q.y, q.z, q.w});
  }
  return state;
}

struct Momentum {
  Vector3<double> sum{0, 0, 0};
  double magnitude = 0;  // the sum of the terms' magnitudes
};

void add(Momentum& momentum, const Vector3<double>& v) {
  momentum.sum = momentum.sum + v;
  momentum.magnitude += std::sqrt(dot(v, v));
}

Momentum momentum_of(const Bodies<float>& bodies) {
  Momentum momentum;
  for (int i = 0; i < bodies.count; ++i)
    if (bodies.inverse_mass[i].w > 0) add(momentum, 1. / bodies.inverse_mass[i].w * wide(bodies.motion[i].velocity));
  return momentum;
}

}  // namespace

StepSettings settings_of(const Scene& scene) {
  StepSettings settings;
  settings.solver.gravity = scene.gravity;
  settings.solver.time_step = scene.time_step;
  settings.solver.substeps = scene.iterations;
  return settings;
}

double residual(const SolverSettings& settings, std::span<const Manifold<float>> manifolds,
                std::span<const std::int32_t> body, const World<float>& start,
                std::span<const Impulses<float>> impulses) {
  Bodies<double> bodies = convert<double>(start).bodies;
  const Array<Impulses<double>> before = widened(impulses);
  Array<Impulses<double>> after = before;
  Array<Motion<double>> moving;
  SolverSettings one_sweep = settings;
  one_sweep.substeps = 1, one_sweep.biased_sweeps = 0, one_sweep.relax_sweeps = 1;
  const Array<Manifold<double>> contacts = widened(manifolds);
  serial::contact_solver_original(one_sweep, std::span<const Manifold<double>>(contacts), body, bodies,
                                  std::span(after), moving);
  double sum = 0, rows = 0;
  for (std::size_t i = 0; i < manifolds.size(); ++i)
    for (int k = 0; k < manifolds[i].count; ++k)
      for (auto row : {&Impulses<double>::normal, &Impulses<double>::tangent, &Impulses<double>::bitangent}) {
        const double change = (after[i].*row)[k] - (before[i].*row)[k];
        sum += change * change, ++rows;
      }
  return rows > 0 ? std::sqrt(sum / rows) : 0;
}

double energy(const Bodies<float>& bodies, const Vector3<double>& gravity) {
  double sum = 0;
  for (int i = 0; i < bodies.count; ++i) {
    const Quad<float>& inverse = bodies.inverse_mass[i];
    if (!(inverse.w > 0)) continue;
    const auto& [position, q, unused] = bodies.pose[i];
    const Vector3<double> v = wide(bodies.motion[i].velocity);
    const Vector3<double> w =
        transposed_times(matrix_of(Quaternion<double>{q.x, q.y, q.z, q.w}), wide(bodies.motion[i].angular_velocity));
    sum += (.5 * dot(v, v) - dot(gravity, wide(position))) / inverse.w;
    sum += .5 * (w.x * w.x / inverse.x + w.y * w.y / inverse.y + w.z * w.z / inverse.z);
  }
  return sum;
}

// An impulse changes two velocities, each by a rounding of the increment (3 u) and of the sum (u). A body's velocity is
// written once per row of its contacts, n times in all. So momentum is off by at most n u (m |v| + 3 impulses). An
// impulse of the step is at most that of a substep times the number of substeps.
RigidRun run_rigid(const Scene& scene, Step<float>* step, int steps) {
  const StepSettings settings = settings_of(scene);
  const SolverSettings& solver = settings.solver;
  World<float> world = scene.world;
  StepMemory<float> memory;
  RigidRun run;
  for (int i = 0; i < steps; ++i) {
    const Momentum before = momentum_of(world.bodies);
    step(settings, world, memory);
    const Momentum after = momentum_of(world.bodies);
    double mass = 0, deepest = 0, impulses = 0;
    for (int b = 0; b < world.bodies.count; ++b)
      if (world.bodies.inverse_mass[b].w > 0) mass += 1. / world.bodies.inverse_mass[b].w;
    bool free = true;  // no contact with a static body
    std::vector<int> rows_of(world.bodies.count, 0);
    for (std::size_t k = 0; k < memory.manifolds.size(); ++k) {
      const Manifold<float>& m = memory.manifolds[k];
      free = free && world.colliders.group[m.a] >= 0 && world.colliders.group[m.b] >= 0;
      for (int p = 0; p < m.count; ++p) {
        deepest = std::max(deepest, -double(m.point[p].separation));
        const Impulses<float>& of = memory.impulses[k];
        impulses += solver.substeps * (std::abs(of.normal[p]) + std::abs(of.tangent[p]) + std::abs(of.bitangent[p]));
      }
      for (const std::int32_t collider : {m.a, m.b}) rows_of[world.colliders.body[collider]] += 3 * m.count;
    }
    const Vector3<double> gained = solver.time_step * mass * solver.gravity;
    const Vector3<double> off = after.sum - before.sum - gained;
    const double writes =
        solver.substeps * (*std::ranges::max_element(rows_of) * (1. + solver.biased_sweeps + solver.relax_sweeps) + 6);
    const double allowed =
        writes * unit_roundoff * (before.magnitude + after.magnitude + std::sqrt(dot(gained, gained)) + 3 * impulses);
    run.frames.push_back({state_of(world.bodies), deepest, energy(world.bodies, solver.gravity),
                          free && allowed > 0 ? std::sqrt(dot(off, off)) / allowed : 0});
  }
  return run;
}

std::vector<double> energy_of_push(const Scene& scene, Step<float>* step, int steps) {
  const StepSettings settings = settings_of(scene);
  StepSettings unpushed = settings;
  unpushed.solver.max_bias_velocity = 0;
  World<float> world = scene.world;
  StepMemory<float> memory;
  std::vector<double> energies;
  for (int i = 0; i < steps; ++i) {
    World<float> other = world;
    StepMemory<float> other_memory = memory;
    step(unpushed, other, other_memory);
    step(settings, world, memory);
    energies.push_back(energy(world.bodies, scene.gravity) - energy(other.bodies, scene.gravity));
  }
  return energies;
}

std::vector<double> energy_forgotten(const Scene& scene, Step<float>* step, const RigidRun& run) {
  const StepSettings settings = settings_of(scene);
  std::vector<double> forgotten(run.frames.size(), 0);
  for (const auto axis : {&Vector3<float>::x, &Vector3<float>::y, &Vector3<float>::z}) {
    World<float> world = scene.world;
    for (int i = 0; i < world.bodies.count; ++i) {
      if (!(world.bodies.inverse_mass[i].w > 0)) continue;
      float& x = world.bodies.pose[i].position.*axis;
      x = std::nextafter(x, i % 2 ? 1e30f : -1e30f);
    }
    StepMemory<float> memory;
    double farthest = 0;
    for (std::size_t f = 0; f < run.frames.size(); ++f) {
      step(settings, world, memory);
      farthest = std::max(farthest, std::abs(energy(world.bodies, settings.solver.gravity) - run.frames[f].energy));
      forgotten[f] += farthest;
    }
  }
  return forgotten;
}

}  // namespace lockstep::verify
