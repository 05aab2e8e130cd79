// Contract: one step of each of several cloths, which do not touch one another: sheets in chains, meshes in batches
// (common/cloth/step.h).
//
// In, out: cloths. A cloth ends up with the bits that its step alone gives it.
// Source:  [ITJ07] and [LRB08] step one cloth. Games have many, and cloths are work for as many cores.
#pragma once

#include <span>

#include "common/cloth/cloth.h"

namespace lockstep::cloth {

template <class Real>
using StepCloths = void(std::span<Cloth<Real>> cloths);

namespace serial {
StepCloths<float> step_cloths;
StepCloths<double> step_cloths;
}  // namespace serial

namespace openmp {
StepCloths<float> step_cloths;
}  // namespace openmp

}  // namespace lockstep::cloth
