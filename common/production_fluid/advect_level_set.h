// Contract: a level set that moves with the velocity.
//
// At the centre of each cell, phi after dt is phi before at the centre's foot (trace.h):
//
//   semi_lagrangian   advected(centre) = phi(foot)
//   maccormack        the same, corrected by what it gives when carried back (maccormack.h)
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
// Errors:  std::bad_alloc.
// Source:  Enright, Losasso and Fedkiw, A fast and accurate semi-Lagrangian particle level set method, Comput. Struct.
//          83 (2005); [ITJ07] "Production Fluid"; maccormack.h.
#pragma once

#include <algorithm>

#include "common/math.h"
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

// --- Cells that need no trace
//
// Far from the surface phi is +-band (redistance.h). Where a cell and those beside it have one value other than zero,
// and no foot is a whole cell away, all that is interpolated is that value, and so is the result, to the bit:
// a + t (a - a) = a. MacCormack's range is that value, too, wherever the way back leads.
//
// No foot is a whole cell away where no velocity exceeds this, one cell in dt less rounding. The trace rounds by less
// than 32 units of the last place of 1 and two of the largest coordinate; 2^-18 of the longest axis is more.
template <class Real>
inline Real speed_of_a_cell(const Field<Real>& phi, Real cells) {
  return (Real(1) - Real(0x1p-18) * static_cast<Real>(std::max({phi.nx, phi.ny, phi.nz}))) / abs(cells);
}

}  // namespace lockstep::production_fluid
