// Contacts reordered into batches, of which no two contacts share a vertex that moves: first fit, as in
// common/batches.h, for four vertices a contact.
//
// A vertex has room for 64 batches. A contact that finds none of them free is a batch of its own, after the others, in
// the order of contacts. Memory: 8 bytes a vertex and 5 a contact.
#pragma once

#include "common/batches.h"
#include "common/production_cloth/contacts.h"

namespace lockstep::production_cloth {

// inverse_mass: 0 of a vertex that is held; contacts may share such vertices.
template <class Real>
Batches make_contact_batches(const Contacts<Real>& contacts, const Array<Real>& inverse_mass);

extern template Batches make_contact_batches(const Contacts<float>&, const Array<float>&);
extern template Batches make_contact_batches(const Contacts<double>&, const Array<double>&);

}  // namespace lockstep::production_cloth
