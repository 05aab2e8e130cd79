// Contract: every particle inside a body is pushed out to its surface, along the shortest way. Friction takes back what
// it has moved along the surface since the step began: at most all of it, and at most friction times the depth.
//
// Pushing a particle out of one body may push it into another. So all bodies are tried in rounds until the particle is
// in none of them, at most most_rounds times: if convex bodies leave room between them, each round brings it nearer to
// a way out; if they leave none, no number of rounds would help. Bodies are convex, and friction moves a particle in
// the tangential plane, so friction does not push it back in.
//
// In:      cloth.previous, m: where particles were when the step began.
// In, out: cloth.position, m; pinned particles do not move, inside a body or not.
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
