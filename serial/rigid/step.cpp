// One step of rigid bodies: find the pairs that may touch, find their contacts, solve the contacts, and move the
// bodies.
//
// Source: [LRB08] Figure 4. The contract stands in common/rigid/step.h.
#include "common/rigid/step.h"

#include "common/real.h"
#include "common/rigid/batches.h"
#include "common/rigid/contact_blocks.h"
#include "common/rigid/integrate.h"
#include "common/rigid/match_contacts.h"
#include "common/stopwatch.h"
#include "serial/spatial/merge_pairs.h"

namespace lockstep::rigid::serial {
namespace {

// Narrow phases: all contacts are found anew, or those of pairs that moved.
void find_all(const Placed<Real>& placed, Real margin, StepMemory<Real>& memory) {
  narrow_phase(placed, memory.pairs, margin, memory.narrow_phase, memory.manifolds);
}
void find_moved(const Placed<Real>& placed, Real margin, StepMemory<Real>& memory) {
  narrow_phase_kept(placed, memory.pairs, margin, memory.narrow_phase, memory.kept, memory.manifolds);
}

std::span<const std::int32_t> bodies_of(const World<Real>& world) {
  return {world.colliders.body.data(), static_cast<std::size_t>(world.colliders.count)};
}

// Calls `finds` for the contacts, `reorders` between matching and solving, and `solves` with the bodies of the
// colliders.
template <class Find, class Reorder, class Solve>
void step(const StepSettings& settings, World<Real>& world, StepMemory<Real>& memory, Find finds, Reorder reorders,
          Solve solves) {
  Stopwatch stopwatch;
  int phase = 0;
  const auto done = [&] { memory.seconds[phase++] = stopwatch.lap(); };
  const Real dt = static_cast<Real>(settings.solver.time_step), margin = static_cast<Real>(settings.margin);
  const Colliders<Real>& colliders = world.colliders;
  const std::span group(colliders.group.data(), colliders.count), body(colliders.body.data(), colliders.count);

  place_colliders(world, margin / 2, memory.placed, memory.bounds);
  done();

  bvh_build(memory.bounds, memory.tree);
  bvh_pairs(memory.tree, memory.bounds, group, memory.bounded);
  const std::span<const Pose<Real>> placed(memory.placed.data(), colliders.count);
  plane_pairs(colliders, placed, memory.bounds, memory.with_planes);
  spatial::serial::merge_pairs(memory.bounded, memory.with_planes, memory.pairs);
  done();

  memory.manifolds.swap(memory.last_manifolds);
  memory.impulses.swap(memory.last_impulses);
  finds({colliders, world.hulls, placed}, margin, memory);
  done();

  memory.impulses.resize(memory.manifolds.size());
  match_contacts(memory.last_manifolds, memory.last_impulses, memory.manifolds, memory.impulses);
  done();

  reorders();
  done();

  solves(body);
  done();

  integrate(memory.moving, dt, world.bodies);
  done();
}

template <class Find>
void step_in_batches(const StepSettings& settings, World<Real>& world, StepMemory<Real>& memory, Find finds) {
  step(
      settings, world, memory, finds,
      [&] { memory.batches = batches_folded(memory.manifolds, bodies_of(world), world.bodies); },
      [&](std::span<const std::int32_t> body) {
        contact_solver_batches(settings.solver, memory.manifolds, body, memory.batches, world.bodies, memory.impulses,
                               memory.moving);
      });
}

}  // namespace

void step_original(const StepSettings& settings, World<Real>& world, StepMemory<Real>& memory) {
  step(
      settings, world, memory, find_all, [] {},
      [&](std::span<const std::int32_t> body) {
        contact_solver_original(settings.solver, memory.manifolds, body, world.bodies, memory.impulses, memory.moving);
      });
}

void step_batches(const StepSettings& settings, World<Real>& world, StepMemory<Real>& memory) {
  step_in_batches(settings, world, memory, find_all);
}

void step_batches_kept(const StepSettings& settings, World<Real>& world, StepMemory<Real>& memory) {
  step_in_batches(settings, world, memory, find_moved);
}

void step_blocks(const StepSettings& settings, World<Real>& world, StepMemory<Real>& memory) {
  step(
      settings, world, memory, find_all,
      [&] { contact_blocks(memory.manifolds, bodies_of(world), world.bodies, memory.blocks); },
      [&](std::span<const std::int32_t> body) {
        contact_solver_blocks(settings.solver, memory.manifolds, body, memory.blocks, world.bodies, memory.impulses,
                              memory.moving);
      });
}

}  // namespace lockstep::rigid::serial
