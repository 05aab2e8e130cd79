// Whole runs of rigid bodies: how far the solver is from a solution, and what physics conserves in a run.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "common/rigid/scene.h"
#include "common/rigid/step.h"
#include "verify/rigid/inputs.h"

namespace lockstep::verify {

// How far impulses and velocities are from solving a contact problem: by how much another sweep, in double and in the
// original order, would change impulses, N s, root mean square over all rows. `start` is the world that the solver was
// given; `impulses` is its result.
double residual(const rigid::SolverSettings& settings, std::span<const rigid::Manifold<float>> manifolds,
                std::span<const std::int32_t> body, const rigid::World<float>& start,
                std::span<const rigid::Impulses<float>> impulses);

// Kinetic and gravitational energy of all moving bodies, J, in double from the float state. Gravity's zero is the
// origin.
double energy(const rigid::Bodies<float>& bodies, const Vector3<double>& gravity);

// A run, step by step: poses and velocities of bodies, the deepest contact, m, and the energy, J. If no body touched a
// static one, also how far the change of momentum is from gravity's, relative to the bound of rounding.
struct RigidRun {
  struct Frame {
    std::vector<float> state;  // [13 body + k]: position, orientation, velocity, angular velocity
    double deepest, energy, momentum_error;
  };
  std::vector<Frame> frames;
};
RigidRun run_rigid(const rigid::Scene& scene, rigid::Step<float>* step, int steps);

// By how much position correction changed the energy in each step of a run, J: the energy after the step minus that
// after the same step without the push that parts penetrating bodies (max_bias_velocity 0).
std::vector<double> energy_of_push(const rigid::Scene& scene, rigid::Step<float>* step, int steps);

// How far apart the energies of a run may be after each step, J. `step` runs three times more, with every body moved by
// one ulp along one axis. The result is how far each of these runs has ever been from `run`, added up over the three.
// Rounding disturbs all axes, and to first order effects add.
std::vector<double> energy_forgotten(const rigid::Scene& scene, rigid::Step<float>* step, const RigidRun& run);

}  // namespace lockstep::verify
