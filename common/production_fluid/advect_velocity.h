// Contract: velocity that moves with itself.
//
// At each face, a component after dt is the component before at the face's foot (trace.h):
//
//   semi_lagrangian   advected(face) = component(foot)
//   maccormack        the same, corrected by what it gives when carried back (maccormack.h)
//
// All three components move by the velocity at the beginning, there and back. At a face, the velocity is the component
// that stands there, and of each other component the mean of the four nearest faces; at a side of the box these are two
// and count twice. Elsewhere it is interpolated, each component on its own grid. A foot outside a component's grid
// takes the value of the nearest position on its boundary.
//
// Where a face and all faces beside it are zero, of either sign, the result is +0. The foot is the face itself, so
// interpolation gives a + 0 (b - a). This is -0 only where a is, and b is a negative value of the padding along x;
// interpolation along y then makes it +0. So such faces, far from the liquid, need no trace.
//
// In:      faces, finite, as is their padding; fewer than 2^31 values a component with padding; dt, s, of either sign.
// Out:     advected, of the same shape, not the same arrays: every face; padding stays as it is.
// Scratch: arrived, of the same shape, other arrays; any content, which afterwards is unspecified. Its padding is
//          finite and stays as it is.
// Errors:  std::bad_alloc.
// Source:  Stam, Stable fluids, SIGGRAPH 1999; [ITJ07] "Production Fluid"; maccormack.h.
#pragma once

#include "common/production_fluid/maccormack.h"
#include "common/production_fluid/state.h"
#include "common/production_fluid/trace.h"

namespace lockstep::production_fluid {

template <class Real>
using AdvectVelocity = void(const Faces<Real>& faces, Real dt, Faces<Real>& advected);
template <class Real>
using AdvectVelocityMacCormack = void(const Faces<Real>& faces, Real dt, Faces<Real>& advected,
                                      Arrived<Faces<Real>>& arrived);

namespace serial {
AdvectVelocity<float> advect_velocity_semi_lagrangian;
AdvectVelocityMacCormack<float> advect_velocity_maccormack;
AdvectVelocity<double> advect_velocity_semi_lagrangian;
AdvectVelocityMacCormack<double> advect_velocity_maccormack;
}  // namespace serial

namespace openmp {
AdvectVelocity<float> advect_velocity_semi_lagrangian;
AdvectVelocityMacCormack<float> advect_velocity_maccormack;
}  // namespace openmp

}  // namespace lockstep::production_fluid
