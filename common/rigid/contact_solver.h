// Contract: impulses that keep touching bodies apart and let friction hold them, by projected Gauss-Seidel.
//
// A linear complementarity problem (common/rigid/contact_constraint.h) is solved row by row: each row's impulse is set to what its own
// condition asks for, and is projected to what it may be; the bodies' velocities carry the change to the rows that come after. A sweep goes
// through all contacts; of a contact first through the friction of its points, then through their normals.
//
//   original   contacts in the order of the manifolds: the best serial order. openmp goes through the graph of what waits for what,
//              level by level, and so has the same bits, but little to do at a time: the lower curve of [ITJ07] Figure 5.
//   batches    contacts in batches of which none share a body that moves (common/batches.h): the upper curve. The serial form
//              solves batch after batch; openmp solves sixteen contacts of a batch at once, on all threads, with a barrier
//              between batches.
//
// One call moves velocities on by a step, in `substeps` equal parts of it, h long. In each,
//
//   v += g h; the impulses of the part before (at first, of the step before) are applied once more: the warm start;
//   `pushing` sweeps through the normals alone, soft where bodies penetrate;
//   bodies move on by v h, which changes separations to first order;
//   `resting` sweeps, rigid and with friction, so that what pushed bodies apart does not stay as speed;
//
// and after all of them bodies that came fast bounce. Substeps are worth more than sweeps: a column of bodies sways in a mode that sweeps
// hardly reach, but that every substep's new separations push back.
//
// In: bodies.pose, inverse_mass, friction, restitution; manifolds, at the poses; impulses[k] of manifold k, from the last step, or 0.
// In, out: bodies.motion. Out: impulses, of the last substep, without what bounces took; moving[body], made to fit: the mean velocities of
// the step, to advance bodies with.
// A static body's motion is read (a conveyor drags what stands on it) and never written; separations do not count it in.
//
// Source: [LRB08] "Rigid Body Simulation" and Figure 13; [ITJ07] Figures 2 to 5. Projected Gauss-Seidel for contacts with warm starting:
//         Catto, Iterative Dynamics with Temporal Coherence (GDC 2005). Substeps: Macklin et al., Small Steps in Physics Simulation
//         (SCA 2019). Soft contacts that relax: Catto, Solver2D (2024).
#pragma once

#include <span>

#include "common/batches.h"
#include "common/rigid/manifold.h"
#include "common/rigid/world.h"

namespace lockstep::rigid {

// Of the points of one manifold, N s, along the normal and the two tangents that make_tangents (common/rigid/contact_row.h) gives.
template <class Real>
struct alignas(8 * sizeof(Real)) Impulses {
  Real normal[most_points], tangent[most_points], bitangent[most_points], unused[most_points];
};

struct SolverSettings {
  double time_step;         // s, of the whole step
  Vector3<double> gravity;  // m/s^2
  int substeps = 10;
  int pushing = 1, resting = 1;     // sweeps a substep
  double hertz = 60, damping = 10;  // of the contact as a spring; never stiffer than a quarter of a substep's rate
  double most_push = 3;             // m/s
  double bounce_from = 1;           // m/s: an approach below that does not bounce
};

template <class Real>
using SolveOriginal = void(const SolverSettings& settings, std::span<const Manifold<Real>> manifolds, std::span<const std::int32_t> body,
                           Bodies<Real>& bodies, std::span<Impulses<Real>> impulses, Array<Motion<Real>>& moving);
template <class Real>
using SolveBatches = void(const SolverSettings& settings, std::span<const Manifold<Real>> manifolds, std::span<const std::int32_t> body,
                          const Batches& batches, Bodies<Real>& bodies, std::span<Impulses<Real>> impulses, Array<Motion<Real>>& moving);

namespace serial {
SolveOriginal<float> solve_contacts_original;
SolveOriginal<double> solve_contacts_original;
SolveBatches<float> solve_contacts_batches;
SolveBatches<double> solve_contacts_batches;
}  // namespace serial

namespace openmp {
SolveOriginal<float> solve_contacts_original;
SolveBatches<float> solve_contacts_batches;
}  // namespace openmp

}  // namespace lockstep::rigid
