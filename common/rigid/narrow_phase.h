// Contract: the narrow phase. Of pairs that a broad phase found, which touch, and where.
//
// Two colliders have points where they are nearer than `margin`, m, >= 0: at margin 0 exactly where they overlap or
// touch. The points hold the two apart if the bodies are pushed along the normal at each: at most four, the deepest
// among them, chosen to be wide apart.
//
// Each kernel takes pairs of the kinds it is for, in any order, and fills manifolds[k] of pairs[k]; count is 0 where
// they do not touch. The manifold's a and b are those of the pair: the normal points from pair.a to pair.b, whichever
// kind each of them is. Colliders and pairs are fewer than 2^29 each: openmp/ numbers the 32-byte records of manifolds,
// four each, with 32 bits.
//
//   spheres      sphere or capsule against sphere, capsule or box: closest points of point, segment and box in closed
//                form
//   planes       plane against any convex: the deepest corners
//   box_box      separating axes (15, face axes preferred to edge axes by a little), then the incident face clipped
//                against the reference face; edges give one point, unless a face beside them is nearly flush
//   gjk, convex_axes, convex_clip
//                all other convex pairs, one after another: the distance, the axes of faces and edges for the depth,
//                and the faces that support the normal clipped against one another (common/rigid/gjk.h, convex_axes.h,
//                convex_clip.h)
//   narrow_phase sorts pairs by kinds, hands them to these, and keeps the manifolds that have points, in the order of
//   the pairs; of pairs with hulls, narrow_phase_kept hands on only those that moved since their contact was found, and
//   refreshes the contacts of the others (common/rigid/kept_contacts.h has the bound of the error)
//
// Source: [LRB08] "Collision Detection", Figures 10 and 12; per kernel in its file.
#pragma once

#include "common/rigid/convex_axes.h"
#include "common/rigid/convex_clip.h"
#include "common/rigid/gjk.h"
#include "common/rigid/kept_contacts.h"
#include "common/rigid/manifold.h"
#include "common/rigid/pairs.h"
#include "common/rigid/world.h"

namespace lockstep::rigid {

template <class Real>
using Collide = void(const Placed<Real>& placed, std::span<const Pair> pairs, Real margin,
                     std::span<Manifold<Real>> manifolds);

// From step to step: of every pair that gjk had, where it ended, in the order of the pairs.
struct NarrowPhaseState {
  Pairs pairs;
  std::vector<Simplex> simplex;
};
// Pairs in order, each once. Out: manifolds, emptied first.
template <class Real>
using NarrowPhase = void(const Placed<Real>& placed, std::span<const Pair> pairs, Real margin, NarrowPhaseState& state,
                         Array<Manifold<Real>>& manifolds);
// As NarrowPhase. kept, from step to step: the contacts; empty before the first step.
template <class Real>
using NarrowPhaseKept = void(const Placed<Real>& placed, std::span<const Pair> pairs, Real margin,
                             NarrowPhaseState& state, KeptContacts<Real>& kept, Array<Manifold<Real>>& manifolds);

namespace serial {
Collide<float> spheres, planes, box_box;
Collide<double> spheres, planes, box_box;
NarrowPhase<float> narrow_phase;
NarrowPhase<double> narrow_phase;
NarrowPhaseKept<float> narrow_phase_kept;
NarrowPhaseKept<double> narrow_phase_kept;
}  // namespace serial

namespace openmp {
Collide<float> spheres, planes, box_box;
NarrowPhase<float> narrow_phase;
NarrowPhaseKept<float> narrow_phase_kept;
}  // namespace openmp

}  // namespace lockstep::rigid
