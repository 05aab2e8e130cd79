// Contract: finds impulses that keep touching bodies apart and let friction hold them, by projected Gauss-Seidel.
//
// A linear complementarity problem (common/rigid/contact_constraint.h) is solved row by row. Each row's impulse is set
// to what its own condition asks for and projected to its allowed range; the bodies' velocities carry the change to the
// rows that follow. A sweep goes through all contacts; in a contact it visits the friction of its points first, then
// the normals.
//
//   original   contacts in the order of the manifolds: the best serial order. openmp goes through the dependence graph
//              level by level. It has the same bits, but little parallelism: the lower curve of [ITJ07] Figure 5.
//   batches    contacts in batches that share no body that moves (common/batches.h): the upper curve. The serial form
//              solves batch after batch; openmp solves sixteen contacts of a batch at once, on all threads, with a
//              barrier between batches.
//   blocks     contacts in blocks of space (common/rigid/contact_blocks.h). The serial form solves block after block;
//              openmp gives a block to one thread, which solves sixteen of its contacts at once. A barrier stands
//              between rounds, which are fewer than batches.
//
// A call advances velocities by one step, in `substeps` equal parts of length h. In each substep,
//
//   1. velocities change by gravity, v += g h, and the impulses of the last substep (at first, of the last step) are
//      applied again: the warm start;
//   2. `biased_sweeps` solve the normals alone, softly where bodies penetrate;
//   3. bodies move by v h, which changes separations to first order;
//   4. `relax_sweeps` solve friction and normals rigidly, which removes the velocity that the bias added.
//
// After all substeps, bodies that came fast bounce. Substeps are worth more than sweeps: a column of bodies sways in a
// mode that sweeps hardly damp, but that the new separations of each substep correct.
//
// In: bodies.pose, inverse_mass, friction, restitution; manifolds at these poses; body[collider]; for manifold k the
// impulses[k] of the last step, 0 at new points. batches or blocks hold each manifold once.
// In, out: bodies.motion. Out: impulses of the last substep, without those of bounces; moving[body], resized: the mean
// velocities of the step, to integrate with.
// A static body's motion is read (a conveyor drags what stands on it), but never written. Separations ignore it.
//
// Source: [LRB08] "Rigid Body Simulation" and Figure 13; [ITJ07] Figures 2 to 5. Projected Gauss-Seidel for contacts
//         with warm starting: Catto, Iterative Dynamics with Temporal Coherence (GDC 2005). Substeps: Macklin et al.,
//         Small Steps in Physics Simulation (SCA 2019). Soft contacts that relax: Catto, Solver2D (2024).
#pragma once

#include <span>

#include "common/batches.h"
#include "common/rigid/contact_blocks.h"
#include "common/rigid/manifold.h"
#include "common/rigid/world.h"

namespace lockstep::rigid {

// The impulses of the points of one manifold, N s, along the normal and the two tangents of make_tangents
// (common/rigid/contact_row.h).
template <class Real>
struct alignas(8 * sizeof(Real)) Impulses {
  Real normal[most_points], tangent[most_points], bitangent[most_points], unused[most_points];
};

struct SolverSettings {
  double time_step;         // s, of the whole step
  Vector3<double> gravity;  // m/s^2
  int substeps = 8;
  int biased_sweeps = 1, relax_sweeps = 1;  // a substep
  double hertz = 60, damping = 10;          // of a contact as a spring: Hz, at most 1 / (4 h); its damping ratio, at
                                            // least 13.4 * 2 pi hertz h
  double max_bias_velocity = 3;             // m/s: the fastest that penetrating bodies are pushed apart
  double bounce_from = 1;                   // m/s: slower approaches do not bounce
};

template <class Real>
using ContactSolverOriginal = void(const SolverSettings& settings, std::span<const Manifold<Real>> manifolds,
                                   std::span<const std::int32_t> body, Bodies<Real>& bodies,
                                   std::span<Impulses<Real>> impulses, Array<Motion<Real>>& moving);
// Order is Batches or ContactBlocks.
template <class Real, class Order>
using ContactSolverReordered = void(const SolverSettings& settings, std::span<const Manifold<Real>> manifolds,
                                    std::span<const std::int32_t> body, const Order& order, Bodies<Real>& bodies,
                                    std::span<Impulses<Real>> impulses, Array<Motion<Real>>& moving);

namespace serial {
ContactSolverOriginal<float> contact_solver_original;
ContactSolverOriginal<double> contact_solver_original;
ContactSolverReordered<float, Batches> contact_solver_batches;
ContactSolverReordered<double, Batches> contact_solver_batches;
ContactSolverReordered<float, ContactBlocks> contact_solver_blocks;
ContactSolverReordered<double, ContactBlocks> contact_solver_blocks;
}  // namespace serial

namespace openmp {
ContactSolverOriginal<float> contact_solver_original;
ContactSolverReordered<float, Batches> contact_solver_batches;
ContactSolverReordered<float, ContactBlocks> contact_solver_blocks;
}  // namespace openmp

}  // namespace lockstep::rigid
