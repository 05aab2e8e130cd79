// Contract: puts contacts into batches, such that no two contacts of a batch share a body that moves. The rule is the
// papers' first fit (common/batches.h): in order, each contact joins the earliest batch that holds neither of its
// bodies. Static bodies conflict with nobody. A contact's points stay together.
//
// batches_parallel gives the same batches, and makes the choice in parallel, too. batches_folded goes round a ring of
// batches instead (make_folded_levels): what it gives is solved nearly as well as the original order, and the step
// takes it (notes/batches.md).
//
// In: manifolds, of two different bodies each; body[collider]; which bodies move. Source: [LRB08] Figure 13; [ITJ07]
// Figures 2 to 4.
#pragma once

#include <span>

#include "common/batches.h"
#include "common/rigid/manifold.h"
#include "common/rigid/world.h"

namespace lockstep::rigid {

template <class Real>
using ReorderContacts = Batches(std::span<const Manifold<Real>> manifolds, std::span<const std::int32_t> body,
                                const Bodies<Real>& bodies);

namespace serial {
ReorderContacts<float> batches, batches_folded;
ReorderContacts<double> batches, batches_folded;
}  // namespace serial

namespace openmp {
ReorderContacts<float> batches, batches_folded, batches_parallel;
}  // namespace openmp

}  // namespace lockstep::rigid
