// Contract: the longest time step in which nothing moves by more than `cfl` cells.
//
//   dt = cfl h / (most + sqrt(h |g|)),
//   most = greatest over cells of max(|u_low|, |u_high|) + max(|v_low|, |v_high|) + max(|w_low|, |w_high|)
//
// where low and high are the two faces of the cell along an axis. sqrt(h |g|) is the speed of what falls by half a cell
// from rest; it bounds the first step of a liquid at rest.
//
// In:      faces, finite; |g|, m/s^2, >= 0; cfl, > 0.
// Returns  dt, s; infinity where nothing moves or falls. A maximum is the same in any order, so all bits are.
// Source:  Enright, Losasso and Fedkiw, Comput. Struct. 83 (2005); gravity: Bridson, Fluid Simulation for Computer
//          Graphics.
#pragma once

#include "common/math.h"
#include "common/production_fluid/state.h"

namespace lockstep::production_fluid {

template <class Real>
using TimeStep = Real(const Faces<Real>& faces, Real gravity, Real cfl);

namespace serial {
TimeStep<float> time_step;
TimeStep<double> time_step;
}  // namespace serial

namespace openmp {
TimeStep<float> time_step;
}  // namespace openmp

// --- Formulas; of numbers or of lanes

// Of a cell, by its two faces along each axis.
template <class Number>
inline Number speed_of(const Number& u_low, const Number& u_high, const Number& v_low, const Number& v_high,
                       const Number& w_low, const Number& w_high) {
  return max(abs(u_low), abs(u_high)) + max(abs(v_low), abs(v_high)) + max(abs(w_low), abs(w_high));
}

template <class Real>
inline Real time_step_of(Real most, Real gravity, Real cfl, Real spacing) {
  return cfl * spacing / (most + sqrt(spacing * gravity));
}

}  // namespace lockstep::production_fluid
