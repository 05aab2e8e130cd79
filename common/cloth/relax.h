// Contract: `iterations` times, every constraint is enforced once (common/cloth/project.h), one after another or as if it were so.
//
// The forms differ in the order, and so in how fast they converge, and in what may run side by side:
//
//   original  the order of cloth.constraints: of a sheet left to right, top to bottom. Nothing may.
//   chains    pass by pass: all vertical constraints, horizontal ones, one diagonal, the other; with bending, two apart after one
//             apart. Along a line of a pass, each constraint shares a particle with the next, so a line is sequential; lines are
//             independent.
//   colours   the same passes, each in two halves, every other constraint of a line first, then those between (for two-apart ones,
//             every other two). All constraints of a half are independent.
//   batches   the order of cloth.batched: batch by batch; those of a batch are independent.
//
// In, out: cloth.position, m; pinned particles stay. chains and colours are for sheets.
// Source:  [Jakobsen 2001] section 3; [LRB08] Figure 11: its passes are said to be independent as a whole, which neighbours
//          along a line, sharing a particle, are not; chains and colours are two ways to make it true.
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
