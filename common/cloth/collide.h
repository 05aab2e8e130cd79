// Contract: every particle that is inside a body is pushed out to its surface, along the shortest way, and what it has moved along
// the surface since the step began is taken back by friction: at most all of it, and at most friction times the depth.
//
// Out of one body may be into another, so a particle goes round the bodies until it is in none of them, most_rounds times at the
// most: between convex bodies with room between them each round brings it nearer; where bodies leave no room nothing would help.
// Bodies are convex, and friction moves a particle in the tangential plane, so it does not push it back in.
//
// In:      cloth.previous, m: where particles were when the step began.
// In, out: cloth.position, m; pinned particles stay, wherever they are.
// Source:  [Jakobsen 2001] sections 3 and 6 (friction); [LRB08] "Cloth Simulation".
#pragma once

#include "common/cloth/cloth.h"

namespace lockstep::cloth {

inline constexpr int most_rounds = 8;

template <class Real>
using Collide = void(Cloth<Real>& cloth);

namespace serial {
Collide<float> collide;
Collide<double> collide;
}  // namespace serial

namespace openmp {
Collide<float> collide;
}  // namespace openmp

}  // namespace lockstep::cloth
