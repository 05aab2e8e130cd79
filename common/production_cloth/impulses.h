// Contract: elements of a cloth that would meet within a step are stopped by impulses: one round.
//
// An impact is a contact with weights and a normal of the moment at which its elements meet. Where they approach, its
// gain (respond.h) is what stops them: no restitution, and Coulomb's friction. An impact that already parts is left
// alone. Impulses at one vertex undo some of each other, and new velocities may lead to new impacts: the caller looks
// for impacts again, and does rounds (collide.h).
//
// The orders `original`, `batches` and `jacobi` are those of repulsions (repulsions.h).
//
// In:      impacts; friction, Coulomb's coefficient; inverse_mass, 1/kg, 0 of a vertex that is held.
// In, out: velocity, m/s, one for each inverse mass.
// Errors:  std::bad_alloc.
// Source:  Bridson, Fedkiw and Anderson, Robust treatment of collisions, contact and friction for cloth animation,
//          SIGGRAPH 2002, section 7.
#pragma once

#include "common/production_cloth/contacts.h"
#include "common/production_cloth/respond.h"

namespace lockstep::production_cloth {

template <class Real>
using Impulses = void(const Contacts<Real>& impacts, Real friction, const Array<Real>& inverse_mass,
                      Vectors<Real>& velocity);

namespace serial {
Impulses<float> impulses_original, impulses_batches, impulses_jacobi;
Impulses<double> impulses_original, impulses_batches, impulses_jacobi;
}  // namespace serial

namespace openmp {
Impulses<float> impulses_batches, impulses_jacobi;
}  // namespace openmp

}  // namespace lockstep::production_cloth
