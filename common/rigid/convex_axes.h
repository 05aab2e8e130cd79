// Contract: of convex colliders whose cores GJK found near, the axis along which the cores are farthest apart or
// overlap least, and the faces whose normals are nearest to it. (A core is a collider's scaled hull without the radius
// it is rounded by.)
//
// In:     pairs; simplex[k] and closest[k] of pairs[k], as gjk left them; margin, m, >= 0.
// Out:    axes[k] of pairs[k], one for each pair, every word of it.
// Errors: none. A pair with NaN in its pose gets an axis with NaN.
//
// Cores that are apart have the line between their closest points. Of cores that overlap or touch, the axis is the best
// of the normals of both cores' faces and the cross products of their edges (separating axes); the depth along it is
// exact to within rounding.
//
// Source: Gottschalk, Lin and Manocha, SIGGRAPH 1996; Gregorius, The Separating Axis Test between Convex Polyhedra, GDC
//         2013. Pruning by a common point is ours. [LRB08] "Collision Detection".
#pragma once

#include <cstdint>
#include <span>

#include "common/rigid/gjk.h"
#include "common/rigid/pairs.h"
#include "common/rigid/world.h"

namespace lockstep::rigid {

// Two records of eight, which lanes load whole.
template <class Real>
struct alignas(8 * sizeof(Real)) SeparatingAxis {
  Vector3<Real> normal;  // unit, from a to b, in a's frame
  // m, of the cores along the axis. Infinity where the surfaces are farther apart than margin: all else is then 0.
  Real separation;
  Vector3<Real> middle;     // m, in a's frame: midway between the points where the cores are closest along it
  Real cosine_a, cosine_b;  // of the angles between it and the faces below: 1 where it is the normal of that face
  // The face of a whose normal is nearest to the axis, and of b nearest to its opposite. -1 of a core without faces.
  std::int32_t face_a, face_b;
  std::int32_t unused[5];
};
static_assert(sizeof(SeparatingAxis<float>) == 64);

template <class Real>
using ConvexAxes = void(const Placed<Real>& placed, std::span<const Pair> pairs, std::span<const Simplex> simplex,
                        std::span<const Closest<Real>> closest, Real margin, std::span<SeparatingAxis<Real>> axes);

namespace serial {
ConvexAxes<float> convex_axes;
ConvexAxes<double> convex_axes;
}  // namespace serial

namespace openmp {
ConvexAxes<float> convex_axes;
}  // namespace openmp

}  // namespace lockstep::rigid
