// Contract: drops of spray fly for one step; those that reach the liquid become particles again.
//
//   v += dt g,  x += dt v        gravity first: after k steps x = x0 + k dt v0 + k (k + 1) / 2 dt^2 g
//
// A drop that leaves through an open top is deleted. A drop is a ball of radius r: at the sides of the box and at
// obstacles it stops where it touches them. There it loses the velocity towards them and keeps the rest, so that it
// slides down and no liquid is lost. So none ends within an obstacle, except where the distance has no gradient, or
// where a drop goes through an obstacle in one step. A drop with phi(x) <= r, which touches the surface, becomes a
// particle of sign -1. Drops do not meet each other, and the air does not slow them down.
//
// In:      fluid: phi and solid finite, as is their padding; gravity, m/s^2; dt, s, >= 0.
//          spray: radii up to h / 2.
// In, out: spray: those that fly on, in their order.
//          particles: what was there, and then those that came back, in the order of the spray. `first` stays as it
//          was: it does not hold any more, if any drop came back.
// Errors:  std::bad_alloc.
// Source:  Enright, Marschner and Fedkiw, Animation and rendering of complex water surfaces, SIGGRAPH 2002; [ITJ07]
//          "Production Fluid".
#pragma once

#include "common/math.h"
#include "common/production_fluid/advect_particles.h"
#include "common/production_fluid/particles.h"
#include "common/production_fluid/state.h"
#include "common/production_fluid/trace.h"
#include "common/vector3.h"

namespace lockstep::production_fluid {

template <class Real>
using AdvanceSpray = void(const Fluid<Real>& fluid, const Vector3<Real>& gravity, Real dt, Spray<Real>& spray,
                          Particles<Real>& particles);

namespace serial {
AdvanceSpray<float> advance_spray;
AdvanceSpray<double> advance_spray;
}  // namespace serial

namespace openmp {
AdvanceSpray<float> advance_spray;
}  // namespace openmp

// --- Formulas; of a drop or of lanes of drops.

template <class Number>
struct Drop {
  Vector3<Number> position, velocity;  // m, m/s
};

template <class Number, class Real>
inline Drop<Number> flown(const Drop<Number>& drop, const Vector3<Real>& gravity, Real dt) {
  const Vector3<Number> gained = {Number(dt * gravity.x), Number(dt * gravity.y), Number(dt * gravity.z)};
  const Vector3<Number> velocity = drop.velocity + gained;
  return {drop.position + Number(dt) * velocity, velocity};
}

// A drop at distance `solid` from obstacles moves out of them, and loses its velocity towards them if it touches them;
// `slope` is that of the distance. Where it vanishes, there is no way out.
template <class Number>
inline Drop<Number> stopped_by_obstacle(const Drop<Number>& drop, const Number& radius, const Number& solid,
                                        const Vector3<Number>& slope) {
  const Number square = dot(slope, slope);
  const auto touches = (solid < radius) & (square > Number(0));
  const Number along = min(dot(drop.velocity, slope), Number(0)) / select(touches, square, Number(1));
  return {drop.position + push_out(solid, radius, slope),
          select(touches, drop.velocity - along * slope, drop.velocity)};
}

// Along one axis.
template <class Number>
inline void stop_at_sides(const Number& least, const Number& most, Number& position, Number& velocity) {
  where(position < least, velocity) = max(velocity, Number(0));
  where(position > most, velocity) = min(velocity, Number(0));
  position = min(max(position, least), most);
}
template <class Number, class Real>
inline void stop_at_sides(const Fluid<Real>& fluid, const Number& radius, Drop<Number>& drop) {
  const Real h = fluid.spacing;
  Vector3<Number>&x = drop.position, &v = drop.velocity;
  stop_at_sides(radius, Number(h * fluid.nx) - radius, x.x, v.x);
  stop_at_sides(radius, Number(h * fluid.ny) - (fluid.open_top ? Number(0) : radius), x.y, v.y);
  stop_at_sides(radius, Number(h * fluid.nz) - radius, x.z, v.z);
}

// Whether a drop has left through an open top.
template <class Number, class Real>
inline auto has_left(const Fluid<Real>& fluid, const Drop<Number>& drop) {
  return drop.position.y > Number(fluid.open_top ? fluid.spacing * fluid.ny : levelset::far<Real>);
}

}  // namespace lockstep::production_fluid
