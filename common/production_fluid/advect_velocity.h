// Contract: velocity that moves with itself.
//
// Each component at each face becomes what it was at the face's foot (trace.h), where dt has passed:
//
//   advected(face) = component(foot)
//
// All three components move by the velocity at the beginning. At a face, the velocity is the component that stands
// there, and of each other component the mean of the four nearest faces; at a side of the box these are two and count
// twice. Elsewhere it is interpolated, each component on its own grid. A foot outside a component's grid takes the
// value of the nearest position on its boundary.
//
// In:      faces, finite, as is their padding; fewer than 2^31 values a component with padding; dt, s, of either sign.
// Out:     advected, of the same shape, not the same arrays: every face; padding stays as it is.
// Source:  Stam, Stable fluids, SIGGRAPH 1999; [ITJ07] "Production Fluid".
#pragma once

#include "common/production_fluid/state.h"
#include "common/production_fluid/trace.h"

namespace lockstep::production_fluid {

template <class Real>
using AdvectVelocity = void(const Faces<Real>& faces, Real dt, Faces<Real>& advected);

namespace serial {
AdvectVelocity<float> advect_velocity;
AdvectVelocity<double> advect_velocity;
}  // namespace serial

namespace openmp {
AdvectVelocity<float> advect_velocity;
}  // namespace openmp

}  // namespace lockstep::production_fluid
