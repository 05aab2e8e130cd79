// Contract: a level set that moves with the velocity.
//
// phi at the centre of each cell becomes what it was at the centre's foot (trace.h), where dt has passed:
//
//   advected(centre) = phi(foot)
//
// At a centre, each component of the velocity is the mean of the cell's two faces. Elsewhere it is interpolated, each
// component on its own grid. A foot outside the grid of centres takes the value of the nearest position on its
// boundary.
//
// In:      phi, m, and faces, m/s, finite, as is their padding; fewer than 2^31 values a field with padding; dt, s, of
//          either sign.
// Out:     advected, of phi's shape, another array: every cell; padding stays as it is.
// Source:  Enright, Losasso and Fedkiw, A fast and accurate semi-Lagrangian particle level set method, Comput. Struct.
//          83 (2005); [ITJ07] "Production Fluid".
#pragma once

#include "common/production_fluid/state.h"
#include "common/production_fluid/trace.h"

namespace lockstep::production_fluid {

template <class Real>
using AdvectLevelSet = void(const Field<Real>& phi, const Faces<Real>& faces, Real dt, Field<Real>& advected);

namespace serial {
AdvectLevelSet<float> advect_level_set;
AdvectLevelSet<double> advect_level_set;
}  // namespace serial

namespace openmp {
AdvectLevelSet<float> advect_level_set;
}  // namespace openmp

}  // namespace lockstep::production_fluid
