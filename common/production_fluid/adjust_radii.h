// Contract: particles' balls touch the surface again.
//
//   r = s phi(x), at least .1 h and at most .5 h
//
// s is the particle's sign, phi is interpolated. A particle on the wrong side gets .1 h.
//
// In:      phi, finite; particles, best sorted, so that neighbours read the same values.
// Out:     particles' radii.
// Source:  Enright, Fedkiw, Ferziger and Mitchell, J. Comput. Phys. 183 (2002); [ITJ07] "Production Fluid".
#pragma once

#include "common/production_fluid/particles.h"
#include "common/production_fluid/state.h"

namespace lockstep::production_fluid {

template <class Real>
using AdjustRadii = void(const Field<Real>& phi, Particles<Real>& particles);

namespace serial {
AdjustRadii<float> adjust_radii;
AdjustRadii<double> adjust_radii;
}  // namespace serial

namespace openmp {
AdjustRadii<float> adjust_radii;
}  // namespace openmp

}  // namespace lockstep::production_fluid
