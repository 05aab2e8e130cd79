// A frame of the liquid.
//
// The order of the modules and its serial form stand in serial/production_fluid/step.cpp. Each module has threads and
// lanes of its own; the code between them takes hardly any time.
//
// The contract stands in common/production_fluid/step.h.
#include "common/production_fluid/step.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/production_fluid/add_sources.h"
#include "common/production_fluid/adjust_radii.h"
#include "common/production_fluid/advance_spray.h"
#include "common/production_fluid/advect_level_set.h"
#include "common/production_fluid/advect_particles.h"
#include "common/production_fluid/advect_velocity.h"
#include "common/production_fluid/apply_forces.h"
#include "common/production_fluid/correct_level_set.h"
#include "common/production_fluid/extrapolate.h"
#include "common/production_fluid/make_system.h"
#include "common/production_fluid/project.h"
#include "common/production_fluid/redistance.h"
#include "common/production_fluid/remove_particles.h"
#include "common/production_fluid/reseed.h"
#include "common/production_fluid/sort_particles.h"
#include "common/production_fluid/time_step.h"
#include "common/real.h"
#include "common/simd.h"
#include "common/stopwatch.h"

namespace lockstep::production_fluid::openmp {
namespace {

struct Forms {
  Redistance<Real>* redistance;
  PressureSolve<Real>* solve;
};

// After gravity has acted for `span`, s. Calls done(module) after each module.
template <class Done>
void make_incompressible(const Model& model, PressureSolve<Real>* solve, double span, Liquid<Real>& liquid,
                         StepMemory<Real>& memory, const Done& done) {
  Fluid<Real>& fluid = liquid.fluid;
  make_system(fluid, memory.system);
  done(Module::make_system);
  PressureSettings settings = model.pressure;
  settings.guess = liquid.pushed > 0 ? span / liquid.pushed : 0;
  memory.iterations += solve(memory.system, settings, memory.pressure, liquid.q).iterations;
  liquid.pushed = span;
  done(Module::pressure_solve);
  project(fluid, memory.system, liquid.q, fluid.velocity);
  done(Module::project);
  extrapolate(fluid, Real(distance_of_extrapolation) * fluid.spacing, fluid.velocity);
  done(Module::extrapolate);
}

void scale(const Field<Real>& given, Real factor, Field<Real>& velocity) {
  // A line is written by one thread, from velocities that none changes.
#pragma omp parallel for collapse(2) schedule(static)
  for (int z = 0; z < given.nz; ++z)
    for (int y = 0; y < given.ny; ++y)
      for (int x = 0; x < given.nx; x += lanes)
        store(&velocity(x, y, z), floatv(factor) * load(&given(x, y, z)), first_lanes(given.nx - x));
}

void set_velocity(const Faces<Real>& given, Real factor, Faces<Real>& velocity) {
  scale(given.u, factor, velocity.u), scale(given.v, factor, velocity.v), scale(given.w, factor, velocity.w);
}

Real longest_step(const Model& model, const Vector3<double>& gravity, const Faces<Real>& velocity) {
  return time_step(velocity, static_cast<Real>(std::sqrt(dot(gravity, gravity))), static_cast<Real>(model.cfl));
}

// Plans the next substep, and applies gravity from the middle of this substep to the middle of the next. `length`, s,
// is that of this substep; `left`, s, is left of a frame after it. Returns for how long gravity acted, s.
double accelerate(const Model& model, double length, double left, Liquid<Real>& liquid) {
  Faces<Real>& velocity = liquid.fluid.velocity;
  liquid.planned = next_substep(longest_step(model, model.gravity, velocity), left);
  const double span = .5 * (length + liquid.planned);
  apply_forces(convert<Real>(model.gravity), static_cast<Real>(span), velocity);
  return span;
}

// A substep that begins `now`, s since the first frame began, and is `length`, s, long; `left`, s, is left of a frame
// after it.
template <class Done>
void substep(const Model& model, const Forms& forms, double now, double length, double left, Liquid<Real>& liquid,
             StepMemory<Real>& memory, const Done& done) {
  const Real dt = static_cast<Real>(length);
  Fluid<Real>& fluid = liquid.fluid;
  Particles<Real>& particles = liquid.particles;
  double span = 0;  // s, for which gravity acts
  advect_level_set_maccormack(fluid.phi, fluid.velocity, dt, memory.phi, memory.arrived);
  std::swap(fluid.phi, memory.phi);
  done(Module::advect_level_set);
  advect_particles(fluid, fluid.velocity, dt, particles);
  done(Module::advect_particles);
  if (!model.given) {
    advance_spray(fluid, convert<Real>(model.gravity), dt, liquid.spray, particles);
    done(Module::advance_spray);
    advect_velocity_semi_lagrangian(fluid.velocity, dt, memory.velocity);
    std::swap(fluid.velocity, memory.velocity);
    done(Module::advect_velocity);
    span = accelerate(model, length, left, liquid);
    done(Module::apply_forces);
  }
  if (!model.sources.empty()) {
    add_sources(model.sources, now, fluid, particles);
    done(Module::add_sources);
  }

  sort_particles(fluid.phi, particles, memory.particles);
  std::swap(particles, memory.particles);
  done(Module::sort_particles);
  const auto extend_and_correct = [&] {
    extend_level_set(memory.extension, fluid.phi);
    done(Module::extend_level_set);
    correct_level_set(particles, fluid.phi);
    done(Module::correct_level_set);
  };
  extend_and_correct();
  forms.redistance(fluid.phi, Real(band_of_level_set) * fluid.spacing, memory.distances);
  done(Module::redistance);
  extend_and_correct();
  if (!model.given) {
    remove_particles(fluid, particles, memory.particles, liquid.spray);
    std::swap(particles, memory.particles);
    done(Module::remove_particles);
  }
  adjust_radii(fluid.phi, particles);
  done(Module::adjust_radii);

  if (!model.given) make_incompressible(model, forms.solve, span, liquid, memory, done);
}

void reseed_blocks(const Model& model, int round, Liquid<Real>& liquid, StepMemory<Real>& memory) {
  reseed(liquid.fluid, {.per_block = model.per_block, .seed = 0, .round = static_cast<std::uint32_t>(round)},
         liquid.particles, memory.particles);
  std::swap(liquid.particles, memory.particles);
}

void step(const Model& model, const Forms& forms, Liquid<Real>& liquid, StepMemory<Real>& memory) {
  Stopwatch stopwatch;
  const auto done = [&](Module module) { memory.seconds[int(module)] += stopwatch.lap(); };
  std::fill(std::begin(memory.seconds), std::end(memory.seconds), 0);
  memory.substeps = memory.iterations = 0;
  for (double left = model.frame, dt; left > 0; left -= dt, ++memory.substeps) {
    const Faces<Real>& fastest = model.given ? memory.given : liquid.fluid.velocity;
    dt = liquid.planned;
    if (!(dt > 0 && dt <= left && dt <= longest_step(model, {0, 0, 0}, fastest)))
      dt = next_substep(longest_step(model, model.gravity, fastest), left);
    const double now = (liquid.frames + 1) * model.frame - left;
    if (model.given) {
      const double factor = factor_of_given(model, now + .5 * dt);
      set_velocity(memory.given, static_cast<Real>(factor), liquid.fluid.velocity);
    }
    done(Module::time_step);
    substep(model, forms, now, dt, left > dt ? left - dt : model.frame, liquid, memory, done);
  }
  const int between = frames_between_reseeding(model);
  if (++liquid.frames % between == 0) {
    reseed_blocks(model, liquid.frames / between, liquid, memory);
    done(Module::reseed);
  }
}

}  // namespace

void step_multigrid(const Model& model, Liquid<Real>& liquid, StepMemory<Real>& memory) {
  step(model, {redistance_sweeping, pressure_solve_multigrid}, liquid, memory);
}

void step_mic(const Model& model, Liquid<Real>& liquid, StepMemory<Real>& memory) {
  step(model, {redistance_sweeping, pressure_solve_mic}, liquid, memory);
}

void step_marching(const Model& model, Liquid<Real>& liquid, StepMemory<Real>& memory) {
  step(model, {redistance_marching, pressure_solve_mic}, liquid, memory);
}

}  // namespace lockstep::production_fluid::openmp
