// A liquid in motion: what a frame begins with and leaves, and what steps work in.
#pragma once

#include <cstdint>
#include <iterator>
#include <vector>

#include "common/levelset/field.h"
#include "common/production_fluid/add_sources.h"
#include "common/production_fluid/extend_level_set.h"
#include "common/production_fluid/maccormack.h"
#include "common/production_fluid/particles.h"
#include "common/production_fluid/pressure_solve.h"
#include "common/production_fluid/state.h"
#include "common/production_fluid/system.h"

namespace lockstep::production_fluid {

// What does not change from frame to frame.
struct Model {
  Vector3<double> gravity = {0, -9.81, 0};  // m/s^2
  double frame = 1. / 24;                   // s, of a frame
  double cfl = .9;                          // the most cells that anything moves in a substep
  int per_block = 16;                       // particles of a block; 0: the level set alone
  // The velocity is not simulated. It is that of the start times cos(pi t / period), or constant if the period is 0.
  bool given = false;
  double period = 0;  // s
  std::vector<Source> sources = {};
  PressureSettings pressure = {.modification = {.tau = .97, .sigma = .25},
                               .stop = {.tolerance = 1e-6, .iterations = 400}};
};

template <class Real>
struct Liquid {
  Fluid<Real> fluid;
  Particles<Real> particles;  // sorted
  Spray<Real> spray;
  std::int32_t frames = 0;  // that have passed
  double planned = 0;       // s, the next substep; gravity has acted to its middle; 0: none is planned
  // What the last pressure left (system.h), where the next solve begins, and for how long gravity had acted before it.
  Array<double> q;
  double pushed = 0;  // s; 0: there is no q
};

// The modules of a step, in their order.
enum class Module {
  time_step,
  advect_level_set,
  advect_particles,
  advance_spray,
  advect_velocity,
  apply_forces,
  add_sources,
  sort_particles,
  extend_level_set,
  correct_level_set,
  redistance,
  remove_particles,
  adjust_radii,
  make_system,
  pressure_solve,
  project,
  extrapolate,
  reseed,
  count
};
inline constexpr const char* name_of_module[] = {
    "time_step",    "advect_level_set", "advect_particles", "advance_spray",     "advect_velocity", "apply_forces",
    "add_sources",  "sort_particles",   "extend_level_set", "correct_level_set", "redistance",      "remove_particles",
    "adjust_radii", "make_system",      "pressure_solve",   "project",           "extrapolate",     "reseed"};
static_assert(std::size(name_of_module) == int(Module::count));

// Scratch, which keeps its room from frame to frame; and counts of the last frame.
template <class Real>
struct StepMemory {
  Faces<Real> given;  // the velocity at the start
  Extension<Real> extension;
  Field<Real> phi;
  Arrived<Field<Real>> arrived;
  Faces<Real> velocity;
  Particles<Real> particles;
  levelset::Distances<Real> distances;
  System<Real> system;
  PressureMemory<Real> pressure;

  int substeps = 0, iterations = 0;         // of the pressure, of all substeps
  double seconds[int(Module::count)] = {};  // by module
};

// The memory of a run that begins with this fluid.
template <class Real>
StepMemory<Real> make_memory(const Fluid<Real>& fluid) {
  StepMemory<Real> memory;
  memory.given = memory.velocity = fluid.velocity;
  memory.extension = make_extension(fluid);
  memory.phi = memory.arrived.value = memory.arrived.least = memory.arrived.most = fluid.phi;
  return memory;
}

// What steps begin with, and what two versions are compared by.
template <Is<Liquid> L, class F>
void for_each_array(L& liquid, const F& f) {
  for_each_array(liquid.fluid, f);
  auto& particles = liquid.particles;
  auto& spray = liquid.spray;
  f("position of particles", particles.position, particles.count);
  f("radius of particles", particles.radius, particles.count);
  f("sign of particles", particles.sign, particles.count);
  f("first particles of blocks", particles.first, particles.first.size());
  f("position of spray", spray.position, spray.count);
  f("velocity of spray", spray.velocity, spray.count);
  f("radius of spray", spray.radius, spray.count);
  f("pressure", liquid.q, liquid.q.size());
}

}  // namespace lockstep::production_fluid
