// Whole runs of rigid bodies: how far the solver is from a solution, and what holds of a run beyond the bits.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "common/rigid/scene.h"
#include "common/rigid/step.h"
#include "verify/rigid/inputs.h"

namespace lockstep::verify {

// How far impulses and velocities are from solving a contact problem: by how much another sweep, in double and in the original order, would
// change impulses, N s, root mean square over all rows. `start` is the world whose bodies the solver was given; `impulses` is what it left.
double residual(const rigid::SolverSettings& settings, std::span<const rigid::Manifold<float>> manifolds,
                std::span<const std::int32_t> body, const rigid::World<float>& start, std::span<const rigid::Impulses<float>> impulses);

// Kinetic and gravitational energy of what moves, J, in double from the float state; gravity's zero is the origin.
double energy(const rigid::Bodies<float>& bodies, const Vector3<double>& gravity);

// A run, step by step: where bodies are and how they move, the deepest contact, m, the energy, J, and, where nothing static touched
// anything, by how much the momentum went another way than gravity's, relative to what rounding allows.
struct RigidRun {
  struct Frame {
    std::vector<float> state;  // [13 body + k]: position, orientation, velocity, angular velocity
    double deepest, energy, momentum_error;
  };
  std::vector<Frame> frames;
};
RigidRun run_rigid(const rigid::Scene& scene, rigid::Step<float>* step, int steps);

// How far apart energies of a run may be after each step, J: `step` runs three times more, with every body moved by one ulp along one
// axis. How far each of them has ever been from `run`, added up over the three: rounding disturbs all axes, and to first order effects add.
std::vector<double> energy_forgotten(const rigid::Scene& scene, rigid::Step<float>* step, const RigidRun& run);

}  // namespace lockstep::verify
