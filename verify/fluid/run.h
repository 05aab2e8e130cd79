// Whole steps and whole runs of the game fluid: what the physical verdict asserts.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "common/fluid/scene.h"
#include "common/fluid/step.h"
#include "verify/kernel.h"

namespace lockstep::verify {

// Runs of the serial reference from one state: as it is, and with every particle moved by one ulp along one axis. How
// fast those leave the first is how fast the scene itself forgets its input.
struct FreeRuns {
  struct Frame {
    std::vector<float> serial;     // [6 id + k]: position (m) and velocity (m/s)
    double serial_energy;          // J
    double positions, velocities;  // m, m/s, rms: how far the perturbed runs have been from the first by now, added up
    double energy;                 // J: how far apart that lets energies be
  };
  std::vector<Frame> frames;
  // Trajectories are compared in so many of them: until the perturbed runs are h / 100 away. Beyond that two runs are
  // two samples of one flow, and only what physics says of each is asked.
  std::size_t comparable;
};
double bytes_of(const FreeRuns& runs);
FreeRuns run_freely(const fluid::Fluid<float>& start, int scene_frames);

// Asserts that one step from the same state leaves every particle as near to the double run as the bounded verdict
// asks.
void check_one_step(Judgement& judgement, const fluid::Fluid<float>& start, const fluid::Fluid<float>& openmp,
                    const fluid::Fluid<float>& serial);

// Asserts of a run of `step` from the state that
//   every number stays finite, and what the scene says holds in each frame (inside the domain, momentum conserved);
//   it leaves the serial run no faster than a serial run with an input moved by one ulp does, in positions and
//   velocities; its energy is as near to the serial run's as that distance allows.
void check_free_run(Judgement& judgement, const FreeRuns& runs, const fluid::Holds& holds,
                    const fluid::Fluid<float>& start, fluid::Step<float>* step);

// Asserts that all particles at least h inside a lattice at rest have its analytic density.
void check_lattice_density(Judgement& judgement, const fluid::Fluid<double>& lattice, std::span<const float> density);

// Kinetic and gravitational energy, J; gravity's zero is the floor of the domain.
double energy(const fluid::Fluid<float>& fluid);

// Whether every particle is inside the domain.
bool inside_domain(const fluid::Fluid<float>& fluid);

// The total momentum (kg m/s), and by how much one step may change it by rounding alone where no outer force acts.
Vector3<double> momentum(const fluid::Fluid<float>& fluid);
double momentum_rounding(const fluid::Fluid<float>& after_step);

}  // namespace lockstep::verify
