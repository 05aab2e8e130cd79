// Contract: a level set that moves with the velocity.
//
// phi at the centre of each cell becomes what it was at the centre's foot (trace.h), where dt has passed:
//
//   semi_lagrangian   advected(centre) = phi(foot)
//   maccormack        the same, corrected by what it becomes when it is carried back (maccormack.h)
//
// At a centre, each component of the velocity is the mean of the cell's two faces. Elsewhere it is interpolated, each
// component on its own grid. A foot outside the grid of centres takes the value of the nearest position on its
// boundary.
//
// In:      phi, m, and faces, m/s, finite, as is their padding; fewer than 2^31 values a field with padding; dt, s, of
//          either sign.
// Out:     advected, of phi's shape, another array: every cell; padding stays as it is.
// Scratch: arrived, of phi's shape, other arrays; any content, which afterwards is unspecified. Its padding is finite
//          and stays as it is.
// Source:  Enright, Losasso and Fedkiw, A fast and accurate semi-Lagrangian particle level set method, Comput. Struct.
//          83 (2005); [ITJ07] "Production Fluid"; maccormack.h.
#pragma once

#include "common/production_fluid/maccormack.h"
#include "common/production_fluid/state.h"
#include "common/production_fluid/trace.h"

namespace lockstep::production_fluid {

template <class Real>
using AdvectLevelSet = void(const Field<Real>& phi, const Faces<Real>& faces, Real dt, Field<Real>& advected);
template <class Real>
using AdvectLevelSetMacCormack = void(const Field<Real>& phi, const Faces<Real>& faces, Real dt, Field<Real>& advected,
                                      Arrived<Field<Real>>& arrived);

namespace serial {
AdvectLevelSet<float> advect_level_set_semi_lagrangian;
AdvectLevelSetMacCormack<float> advect_level_set_maccormack;
AdvectLevelSet<double> advect_level_set_semi_lagrangian;
AdvectLevelSetMacCormack<double> advect_level_set_maccormack;
}  // namespace serial

namespace openmp {
AdvectLevelSet<float> advect_level_set_semi_lagrangian;
AdvectLevelSetMacCormack<float> advect_level_set_maccormack;
}  // namespace openmp

}  // namespace lockstep::production_fluid
