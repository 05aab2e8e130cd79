// Contract: one step of the game cloth: model.substeps times verlet, relax with model.iterations iterations, collide.
//
// In, out: cloth; no particle is left inside a body. chains and colours are for sheets.
// Source:  [Jakobsen 2001]; [LRB08] "Cloth Simulation" and Figure 2.
#pragma once

#include "common/cloth/cloth.h"

namespace lockstep::cloth {

template <class Real>
using Step = void(Cloth<Real>& cloth);

namespace serial {
Step<float> step_original, step_chains, step_colours, step_batches;
Step<double> step_original, step_chains, step_colours, step_batches;
}  // namespace serial

namespace openmp {
Step<float> step_chains, step_colours, step_batches;
}  // namespace openmp

}  // namespace lockstep::cloth
