// Contract: nonlinear Gauss-Seidel: `iterations` times, every constraint is projected once (common/cloth/project.h),
// with the result of doing so one after another.
//
// The forms differ in the order, hence in the rate of convergence and in which constraints are independent:
//
//   original  the order of cloth.constraints: of a sheet left to right, top to bottom. None are.
//   chains    pass by pass: all vertical constraints, horizontal ones, one diagonal, the other; with bending, two apart
//             after one apart. Along a line of a pass, each constraint shares a particle with the next, so a line is
//             sequential; lines are independent.
//   colours   the same passes, each in two halves: every other constraint of a line first, then those between (for
//             two-apart ones, every other two). All constraints of a half are independent.
//   batches   the order of cloth.batched, batch by batch. All constraints of a batch are independent.
//
// In, out: cloth.position, m; pinned particles do not move. chains and colours are for sheets.
// Source:  [Jakobsen 2001] section 3; [LRB08] Figure 11. The paper calls the constraints of a pass independent;
//          neighbours along a line share a particle, so they are not. chains and colours are two ways to make the
//          statement true.
#pragma once

#include "common/cloth/cloth.h"

namespace lockstep::cloth {

template <class Real>
using Relax = void(Cloth<Real>& cloth, int iterations);

namespace serial {
Relax<float> relax_original, relax_chains, relax_colours, relax_batches;
Relax<double> relax_original, relax_chains, relax_colours, relax_batches;
}  // namespace serial

namespace openmp {
Relax<float> relax_chains, relax_colours, relax_batches;
}  // namespace openmp

}  // namespace lockstep::cloth
