// Contract: contacts put into batches of which none share a body that moves, by the papers' rule (common/batches.h): in order, each into
// the earliest batch where neither of its bodies stands. Static bodies conflict with nobody. A contact's points stay together.
//
// reorder_contacts_parallel gives the same batches, with the choice shared out, too; the step takes reorder_contacts (notes/batches.md).
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
ReorderContacts<float> reorder_contacts;
ReorderContacts<double> reorder_contacts;
}  // namespace serial

namespace openmp {
ReorderContacts<float> reorder_contacts, reorder_contacts_parallel;
}  // namespace openmp

}  // namespace lockstep::rigid
