// Contract: escaped particles put the level set right.
//
// A particle has escaped if phi, interpolated, says that it stands on the other side of the surface by more than its
// radius (particles.h). Its ball is then what its sign says, liquid or air. At each of the eight centres c around it,
//
//   phi_p(c) = s (r - |c - x|),  s its sign, r its radius, x its position.
//
// phi+ is the greatest of phi and of phi_p of the escaped particles of air, phi- the least of phi and of those of
// liquid. Then phi becomes the one of less magnitude, phi+ where they are equal. Where no particle has escaped, phi
// keeps its bits. All particles are tested against phi as it was, so neither their order nor what others correct makes
// a difference.
//
// In:      particles, sorted: `first` holds.
// In, out: phi, finite; its padding stays as it is.
// Errors:  std::bad_alloc.
// Source:  Enright, Fedkiw, Ferziger and Mitchell, J. Comput. Phys. 183 (2002); [ITJ07] "Production Fluid".
#pragma once

#include "common/math.h"
#include "common/production_fluid/particles.h"
#include "common/production_fluid/state.h"
#include "common/production_fluid/trace.h"

namespace lockstep::production_fluid {

template <class Real>
using CorrectLevelSet = void(const Particles<Real>& particles, Field<Real>& phi);

namespace serial {
CorrectLevelSet<float> correct_level_set;
CorrectLevelSet<double> correct_level_set;
}  // namespace serial

namespace openmp {
CorrectLevelSet<float> correct_level_set;
}  // namespace openmp

// --- Formulas

// phi_p at a centre; `away` is the vector to it, in cells. 0 is added so that zeros are positive: of two zeros, max and
// min would choose by order.
template <class Real>
inline Real level_of_ball(Real sign, Real radius, const Vector3<Real>& away, Real spacing) {
  return sign * (radius - spacing * sqrt(dot(away, away))) + Real(0);
}

// Of numbers or of lanes.
template <class Number>
inline Number of_less_magnitude(const Number& plus, const Number& minus) {
  return select(abs(plus) <= abs(minus), plus, minus);
}

// Takes phi_p of an escaped particle into phi+ or phi- of a centre.
template <class Real>
inline void correct_centre(Real sign, Real level, Real& plus, Real& minus) {
  if (sign > 0)
    plus = max(plus, level);
  else
    minus = min(minus, level);
}

}  // namespace lockstep::production_fluid
