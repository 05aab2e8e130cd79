// Contract: liquid pours in. A source is a ball that is full of liquid, which moves at one velocity, for as long as the
// source runs.
//
//   phi = min(phi, |c - x| - r)   at cells x that are not solid and are within a ball's box, see below
//   u = the source's component    on faces whose own position lies in a ball, |c - x| < r
//   sign = -1                     of particles that lie in a ball
//
// c is the ball's centre, r its radius. The box about a ball has the cells whose centres are within the ball's radius
// and the band of the level set, along each axis. In other cells |c - x| - r is more than a level set holds. So the
// level set is that of the union, in the whole band. A cell in an obstacle keeps its phi, as obstacles get theirs from
// the open cells (extend_level_set.h). A closed face gets its velocity, and loses it in project.
//
// Particles of air in a ball become particles of liquid. As particles of air they would have escaped, and would open
// the ball again; as particles of liquid none has, since phi is negative there.
//
// Sources act in their order: where two balls meet, faces have the velocity of the later.
//
// In:      sources, finite, r > 0; time, s: sources with until <= time have ceased.
// In, out: fluid, finite: phi and velocity, of which padding stays as it is; particles, in any order: their sign.
// Source:  The union of level sets: Osher and Fedkiw, Level Set Methods and Dynamic Implicit Surfaces (2003), 1.4.
//          Pouring water: Enright, Marschner and Fedkiw, Animation and rendering of complex water surfaces, SIGGRAPH
//          2002.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "common/convert.h"
#include "common/production_fluid/particles.h"
#include "common/production_fluid/redistance.h"
#include "common/production_fluid/state.h"

namespace lockstep::production_fluid {

struct Source {
  Vector3<double> centre = {0, 0, 0};                      // m
  double radius = 0;                                       // m
  Vector3<double> velocity = {0, 0, 0};                    // m/s
  double until = std::numeric_limits<double>::infinity();  // s, since the first frame began
};

template <class Real>
using AddSources = void(const std::vector<Source>& sources, double time, Fluid<Real>& fluid,
                        Particles<Real>& particles);

namespace serial {
AddSources<float> add_sources;
AddSources<double> add_sources;
}  // namespace serial

namespace openmp {
AddSources<float> add_sources;
}  // namespace openmp

// Cells begin .. end - 1 of a line.
struct Range {
  int begin = 0, end = 0;
};

// The cells, of n, whose centres are at most `reach` from a position, all in cells; and at most one more on each side.
inline Range cells_near(double position, double reach, int n) {
  const auto cell = [n](double x) { return static_cast<int>(std::clamp(x, 0., double(n))); };
  return {cell(std::floor(position - .5 - reach)), cell(std::ceil(position + .5 + reach))};
}

// The box about a ball.
struct NearBall {
  Range x, y, z;
};
template <class Real>
NearBall near_ball(const Source& source, const Fluid<Real>& fluid) {
  const double per_cell = 1. / fluid.spacing, reach = per_cell * source.radius + band_of_level_set;
  const auto [x, y, z] = per_cell * source.centre;
  return {cells_near(x, reach, fluid.nx), cells_near(y, reach, fluid.ny), cells_near(z, reach, fluid.nz)};
}

template <class Real>
struct Ball {
  Vector3<Real> centre;    // m
  Real radius;             // m
  Vector3<Real> velocity;  // m/s
};
template <class Real>
Ball<Real> ball_of(const Source& source) {
  return {convert<Real>(source.centre), static_cast<Real>(source.radius), convert<Real>(source.velocity)};
}

// --- Formulas; of a number or of lanes

// The level set of a ball, m.
template <class Number, class Real>
inline Number level_of(const Ball<Real>& ball, const Vector3<Number>& position) {
  const Vector3<Number> away = {position.x - Number(ball.centre.x), position.y - Number(ball.centre.y),
                                position.z - Number(ball.centre.z)};
  return sqrt(dot(away, away)) - Number(ball.radius);
}

}  // namespace lockstep::production_fluid
