// Contract: one step of rigid bodies, the pipeline of [LRB08] Figure 4:
//
//   place_colliders, broad phase, plane_pairs, narrow_phase, match_contacts, batches, contact solver, integrate
//
//   original       contacts solved in the order of their pairs
//   batches        contacts reordered into batches without conflicts (batches_folded, common/rigid/batches.h)
//   blocks         contacts cut into blocks of space (common/rigid/contact_blocks.h), for many cores
//   batches_kept   as batches; pairs with hulls that hardly moved keep their contacts (common/rigid/kept_contacts.h)
//
// In, out: world.bodies; the memory of the last step. Source: [LRB08] Figure 4; [ITJ07] "Game Physics".
#pragma once

#include <array>

#include "common/rigid/broad_phase.h"
#include "common/rigid/contact_solver.h"
#include "common/rigid/narrow_phase.h"
#include "common/rigid/world.h"

namespace lockstep::rigid {

inline constexpr std::array phase_names = {"place",   "broad phase", "narrow phase", "match",
                                           "reorder", "solve",       "advance"};
inline constexpr int phases = static_cast<int>(phase_names.size());

struct StepSettings {
  double margin = .01;  // m: contacts are found before they touch, so that the solver can stop bodies at the surface
  SolverSettings solver;
};

// What a step keeps for the next one and for observers. All of it is empty before the first step.
template <class Real>
struct StepMemory {
  Array<Pose<Real>> placed;
  Bounds<Real> bounds;
  Tree<Real> tree;
  Pairs bounded, with_planes, pairs;
  NarrowPhaseState narrow_phase;
  KeptContacts<Real> kept;
  Array<Manifold<Real>> manifolds, last_manifolds;
  Array<Impulses<Real>> impulses, last_impulses;  // [manifold]
  Batches batches;
  ContactBlocks blocks;
  Array<Motion<Real>> moving;
  std::array<double, phases> seconds = {};  // of the last step, by phase
};

template <class Real>
using Step = void(const StepSettings& settings, World<Real>& world, StepMemory<Real>& memory);

namespace serial {
Step<float> step_original, step_batches, step_batches_kept, step_blocks;
Step<double> step_original, step_batches, step_batches_kept, step_blocks;
}  // namespace serial

namespace openmp {
Step<float> step_original, step_batches, step_batches_kept, step_blocks;
}  // namespace openmp

}  // namespace lockstep::rigid
