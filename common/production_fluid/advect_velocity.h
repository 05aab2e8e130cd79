// Contract: velocity that moves with itself.
//
// Each component at each face becomes what it was at the face's foot (trace.h), where dt has passed:
//
//   semi_lagrangian   advected(face) = component(foot)
//   maccormack        the same, corrected by what it becomes when it is carried back (maccormack.h)
//
// All three components move by the velocity at the beginning, there and back. At a face, the velocity is the component
// that stands there, and of each other component the mean of the four nearest faces; at a side of the box these are two
// and count twice. Elsewhere it is interpolated, each component on its own grid. A foot outside a component's grid
// takes the value of the nearest position on its boundary.
//
// Where a face and all faces beside it are zero, of either sign, so is the result, with a positive sign: the foot is
// the face itself, and a + t (b - a) of zeros is -0 nowhere but beside padding along x; along y it is +0 again. In the
// air, far from the liquid, faces need no trace for that.
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
