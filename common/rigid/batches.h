// Contract: contacts put into batches of which none share a body that moves, by the papers' rule (common/batches.h): in order, each into
// the earliest batch where neither of its bodies stands. Static bodies conflict with nobody. A contact's points stay together.
//
// batches_parallel gives the same batches, with the choice shared out, too; the step takes batches (notes/batches.md).
//
// In: manifolds, of two different bodies each; body[collider]; which bodies move. Source: [LRB08] Figure 13; [ITJ07] Figures 2 to 4.
#pragma once

#include <span>

#include "common/batches.h"
#include "common/rigid/manifold.h"
#include "common/rigid/world.h"

namespace lockstep::rigid {

template <class Real>
using ReorderContacts = Batches(std::span<const Manifold<Real>> manifolds, std::span<const std::int32_t> body, const Bodies<Real>& bodies);

namespace serial {
ReorderContacts<float> batches;
ReorderContacts<double> batches;
}  // namespace serial

namespace openmp {
ReorderContacts<float> batches, batches_parallel;
}  // namespace openmp

}  // namespace lockstep::rigid
