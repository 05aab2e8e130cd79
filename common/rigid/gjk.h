// Contract: the distance of convex cores and the points where they are closest, by the algorithm of Gilbert, Johnson
// and Keerthi.
//
// A core is a collider's scaled hull without the radius it is rounded by. The difference of two cores is convex, too;
// their distance is its distance from the origin. GJK walks towards it: of a simplex of up to four corners it keeps
// those that the closest point lies between, and adds the corner that is farthest towards the origin, until none is
// nearer by more than rounding.
//
// In: pairs of convex colliders, and simplex[k], where to start: the one of the last step, or all zero. Out:
//     closest[k]; simplex[k].
// Works relative to collider a, so that where in the world the pair stands does not matter.
//
// Source: [LRB08] "Collision Detection"; Gilbert, Johnson and Keerthi, IEEE J. Robotics and Automation 4 (1988);
//         sub-distances as in Montanari, Petrinic and Barbieri, ACM Trans. Graphics 36 (2017), or Ericson, Real-Time
//         Collision Detection (2005), 9.5.
#pragma once

#include <cstdint>
#include <span>

#include "common/rigid/pairs.h"
#include "common/rigid/world.h"

namespace lockstep::rigid {

// Corners of the difference: of each, a vertex of a's hull and one of b's.
struct Simplex {
  std::int32_t count;  // 0 .. 4
  std::uint8_t a[4], b[4];
};

template <class Real>
struct Closest {
  Vector3<Real> on_a, on_b;  // m, in the world; where the cores overlap, a point of both as near as GJK came
  Real distance;             // m; 0 where the cores overlap
  std::int32_t iterations;
};

template <class Real>
using Gjk = void(const Placed<Real>& placed, std::span<const Pair> pairs, std::span<Simplex> simplex,
                 std::span<Closest<Real>> closest);

namespace serial {
Gjk<float> gjk;
Gjk<double> gjk;
}  // namespace serial

namespace openmp {
Gjk<float> gjk;
}  // namespace openmp

}  // namespace lockstep::rigid
