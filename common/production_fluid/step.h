// Contract: a frame of the liquid, 1/24 s unless the model says otherwise, in substeps.
//
// A substep takes dt so that nothing moves by more than `cfl` cells (time_step.h), and the frame ends on a substep
// (next_substep). Its modules, in this order:
//
//   advect_level_set (maccormack), advect_particles, advance_spray, advect_velocity (semi_lagrangian)
//                                  all by the velocity at the beginning
//   apply_forces                   gravity, from the middle of this substep to the middle of the next
//   add_sources                    after all that moves liquid, before its particles put the surface right
//   sort_particles                 with the spray that came back
//   extend_level_set               into obstacles
//   correct_level_set              by escaped particles, before redistancing, which would move the surface for good
//   redistance, extend_level_set   to band_of_level_set cells
//   correct_level_set              what redistancing has changed
//   remove_particles, adjust_radii   in this order: spray keeps the radius that it has, others get new ones
//   make_system, pressure_solve, project   the velocity loses its divergence
//   extrapolate                    into the air, where the next substep reads it
//
// Gravity leads the surface by half a substep (leapfrog): it acts for half of this substep and half of the next, which
// is planned from the advected velocity, and `start` begins with half of the first. The next substep is as long as
// planned unless something would then move by more than `cfl` cells. Were gravity to act for this substep alone, waves
// would grow: their substeps are longest where they turn round (notes/production_fluid.md, "Gravity").
//
// Every twentieth frame ends with reseed, and every frame of a model with sources: what they pour in has no particles
// yet. Where the velocity is given, it is that of the middle of the substep, and the modules that change it are left
// out. So are spray, which would leave the given flow, and the removal of particles, which would make spray.
//
//   multigrid  redistances by sweeping, solves with multigrid
//   mic        redistances by sweeping, solves with mic
//   marching   redistances by marching, solves with mic
//
// In, out: liquid, finite, its particles sorted, its velocity free of divergence and extrapolated: as `start` or a
//          frame left it.
// Scratch: memory, from `start`.
// Out:     memory: counts and seconds of the frame.
// Errors:  std::bad_alloc.
// Source:  [ITJ07] "Production Fluid"; the order of modules is that of PhysBAM, with which the paper's authors began.
//          Leapfrog with steps that vary: Hairer, Lubich and Wanner, Geometric Numerical Integration, Acta Numer. 12
//          (2003).
//          Enright, Marschner and Fedkiw, Animation and rendering of complex water surfaces, SIGGRAPH 2002.
#pragma once

#include <cmath>
#include <numbers>

#include "common/production_fluid/liquid.h"

namespace lockstep::production_fluid {

template <class Real>
using Step = void(const Model& model, Liquid<Real>& liquid, StepMemory<Real>& memory);

namespace serial {
// Makes what frames begin with: the liquid of sources, particles, and a velocity without divergence, half a substep
// ahead. The liquid has none of these yet.
Step<float> start;
Step<double> start;

Step<float> step_multigrid, step_mic, step_marching;
Step<double> step_multigrid, step_mic, step_marching;
}  // namespace serial

namespace openmp {
Step<float> step_multigrid, step_mic, step_marching;
}  // namespace openmp

inline int frames_between_reseeding(const Model& model) { return model.sources.empty() ? 20 : 1; }

// What a given velocity is multiplied by at a time, s since the first frame began.
inline double factor_of_given(const Model& model, double time) {
  return model.period > 0 ? std::cos(std::numbers::pi * time / model.period) : 1;
}

// The length of the next substep, s: the longest that is allowed, or what is left of the frame. The last two substeps
// are of about equal length, so that none is tiny.
inline double next_substep(double longest, double left) {
  if (longest >= left) return left;
  return 2 * longest >= left ? .51 * left : longest;
}

// Farther than particles are seeded, and nearer than the band of the level set, beyond which phi is the same
// everywhere.
inline constexpr float distance_of_extrapolation = 3.5f;  // cells

}  // namespace lockstep::production_fluid
