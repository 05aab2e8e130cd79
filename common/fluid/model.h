// The game fluid's constants: smoothed particle hydrodynamics after [Mueller 2003], with the constants of the model
// that PARSEC 3.0 fluidanimate (the public descendant of the papers' game fluid) runs, so that its files and frames
// compare. The equations stand in notes/fluid.md.
#pragma once

#include <numbers>

#include "common/convert.h"
#include "common/vector3.h"

namespace lockstep::fluid {

// SI units. Read-only while a simulation runs.
template <class Real>
struct Model {
  Real particles_per_metre;              // at rest, along an axis; the one parameter that sets the resolution
  Real smoothing_length;                 // h, m: particles farther apart do not interact
  Real smoothing_length_2;               // h^2
  Real twice_rest_density;               // kg/m^3
  Real least_density;                    // kg/m^3: 0, or the rest density of a fluid without cohesion
  Real density_coefficient;              // mass * 315 / (64 pi h^9), the poly6 kernel
  Real pressure_coefficient;             // the spiky kernel's gradient with stiffness and mass
  Real viscosity_coefficient;            // the viscosity kernel's Laplacian with viscosity and mass
  Real min_distance_2;                   // m^2: keeps the direction between two coincident particles finite
  Real time_step;                        // s
  Vector3<Real> gravity;                 // m/s^2
  Vector3<Real> domain_min, domain_max;  // m
  bool walls;                            // whether the domain's six faces hold the fluid in
  Real wall_reach;                       // m: a wall pushes particles that come nearer than this
  Real wall_min_depth;                   // m: ... by more than this
  Real wall_stiffness;                   // 1/s^2
  Real wall_damping;                     // 1/s
};

// What a fluid is made of, and how finely time is cut. The defaults are fluidanimate's: springy, for the speed of sound
// is sqrt(stiffness) = 1.7 m/s (notes/fluid.md, "Water").
struct Matter {
  double stiffness = 3;        // m^2/s^2: pressure = stiffness (density - rest_density)
  double viscosity = .4;       // Pa s
  double rest_density = 1000;  // kg/m^3
  double time_step = .001;     // s
  bool cohesion = true;  // whether fluid thinner than at rest pulls itself together: its pressure is then < 0, not 0
};

// The model at a resolution of `particles_per_metre` > 0, in the standard domain, with gravity and walls.
inline Model<double> make_model(double particles_per_metre, const Matter& matter = {}) {
  const auto& [stiffness, viscosity, rest_density, time_step, cohesion] = matter;
  const double h = 1.695 / particles_per_metre, h2 = h * h, h6 = h2 * h2 * h2, h9 = h6 * h2 * h;
  const double mass = rest_density / (particles_per_metre * particles_per_metre * particles_per_metre);
  return {
      .particles_per_metre = particles_per_metre,
      .smoothing_length = h,
      .smoothing_length_2 = h2,
      .twice_rest_density = 2 * rest_density,
      .least_density = cohesion ? 0 : rest_density,
      .density_coefficient = mass * 315 / (64 * std::numbers::pi * h9),
      .pressure_coefficient = 3 * 15 / (std::numbers::pi * h6) * .5 * stiffness * mass,
      .viscosity_coefficient = viscosity * 45 / (std::numbers::pi * h6) * mass,
      .min_distance_2 = 1e-12,
      .time_step = time_step,
      .gravity = {0, -9.8, 0},
      .domain_min = {-.065, -.08, -.065},
      .domain_max = {.065, .1, .065},
      .walls = true,
      .wall_reach = .0002,
      .wall_min_depth = 1e-10,
      .wall_stiffness = 30000,
      .wall_damping = 128,
  };
}

template <class To, class From>
Model<To> convert(const Model<From>& m) {
  return {
      .particles_per_metre = static_cast<To>(m.particles_per_metre),
      .smoothing_length = static_cast<To>(m.smoothing_length),
      .smoothing_length_2 = static_cast<To>(m.smoothing_length_2),
      .twice_rest_density = static_cast<To>(m.twice_rest_density),
      .least_density = static_cast<To>(m.least_density),
      .density_coefficient = static_cast<To>(m.density_coefficient),
      .pressure_coefficient = static_cast<To>(m.pressure_coefficient),
      .viscosity_coefficient = static_cast<To>(m.viscosity_coefficient),
      .min_distance_2 = static_cast<To>(m.min_distance_2),
      .time_step = static_cast<To>(m.time_step),
      .gravity = convert<To>(m.gravity),
      .domain_min = convert<To>(m.domain_min),
      .domain_max = convert<To>(m.domain_max),
      .walls = m.walls,
      .wall_reach = static_cast<To>(m.wall_reach),
      .wall_min_depth = static_cast<To>(m.wall_min_depth),
      .wall_stiffness = static_cast<To>(m.wall_stiffness),
      .wall_damping = static_cast<To>(m.wall_damping),
  };
}

}  // namespace lockstep::fluid
