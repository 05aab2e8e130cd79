// The whole state of a game fluid.
#pragma once

#include <utility>

#include "common/fluid/grid.h"
#include "common/fluid/model.h"
#include "common/fluid/neighbours.h"
#include "common/fluid/particles.h"

namespace lockstep::fluid {

// Owns everything; one thread of control at a time may step it.
template <class Real>
struct Fluid {
  Model<Real> model;
  Grid<Real> grid;
  Particles<Real> particles;
  Particles<Real> sorted;       // where rebuild_grid writes; then the two are swapped
  Neighbours<Real> neighbours;  // of the forms that keep lists
  Array<Real> density;          // kg/m^3, of each particle
  Vectors<Real> acceleration;   // m/s^2, of each particle
};

// The arrays that a step reads from the step before.
template <Is<Fluid> S, class F>
void for_each_array(S& fluid, const F& f) {
  for_each_array(fluid.particles, f);
}

// A simulation at its first instant. Takes the particles, whose ids must be 0 .. count - 1 in some order.
template <class Real>
Fluid<Real> make_fluid(const Model<Real>& model, Particles<Real> particles) {
  Fluid<Real> fluid{.model = model,
                    .grid = make_grid(model),
                    .particles = std::move(particles),
                    .sorted = {},
                    .neighbours = {},
                    .density = {},
                    .acceleration = {}};
  const int n = fluid.particles.count;
  fluid.sorted.resize(n);
  fluid.neighbours = make_neighbours(fluid.grid, n);
  fluid.density.resize(padded(n));
  fluid.acceleration.resize(n);
  return fluid;
}

}  // namespace lockstep::fluid
