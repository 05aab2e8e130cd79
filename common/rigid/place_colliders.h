// Contract: moves colliders to where their bodies are, and puts a box along the world's axes around each, for the broad
// phase.
//
// The box is the smallest that holds the collider, widened by `margin`, m, on every side. A plane has no bounds: its
// box is whole_space.
//
// In: world.bodies.pose, world.colliders, world.hulls. Out: placed[collider] and bounds[collider], resized.
// Source: [LRB08] Figure 5, "the bounding volume of each object along its axis".
#pragma once

#include "common/rigid/world.h"
#include "common/spatial/bounds.h"

namespace lockstep::rigid {

using spatial::Bounds;
using spatial::Box;
using spatial::empty_box;
using spatial::whole_space;

template <class Real>
using PlaceColliders = void(const World<Real>& world, Real margin, Array<Pose<Real>>& placed, Bounds<Real>& bounds);

namespace serial {
PlaceColliders<float> place_colliders;
PlaceColliders<double> place_colliders;
}  // namespace serial

namespace openmp {
PlaceColliders<float> place_colliders;
}  // namespace openmp

}  // namespace lockstep::rigid
