// Contract: of convex colliders and the axis of each pair, up to four points that hold the two apart along it.
//
// In:     pairs; axes[k] of pairs[k], as convex_axes made them; margin, m, >= 0.
// Out:    manifolds[k] of pairs[k], one for each pair, every word of it; count is 0 where the two are farther apart
//         than margin.
// Errors: none.
//
// The face of a and the face of b that support the normal best are clipped against one another. The deepest of the
// points has the depth that the axis says: where the faces do not hold it, the point midway between the closest points
// is one more.
//
// Source: clipping, Cyrus and Beck, Computers & Graphics 3 (1978); [LRB08] "Collision Detection".
#pragma once

#include <span>

#include "common/rigid/convex_axes.h"
#include "common/rigid/manifold.h"

namespace lockstep::rigid {

template <class Real>
using ConvexClip = void(const Placed<Real>& placed, std::span<const Pair> pairs,
                        std::span<const SeparatingAxis<Real>> axes, Real margin, std::span<Manifold<Real>> manifolds);

namespace serial {
ConvexClip<float> convex_clip;
ConvexClip<double> convex_clip;
}  // namespace serial

namespace openmp {
ConvexClip<float> convex_clip;
}  // namespace openmp

}  // namespace lockstep::rigid
