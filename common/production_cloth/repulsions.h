// Contract: elements of a cloth that are near each other are kept apart by impulses, before anything collides.
//
// near_contacts: of the pairs given, those nearer than the thickness h. Point-triangle pairs come first, each kind in
//   the order of pairs. The closest points are the elements' own, clamped to them. The normal is the direction from
//   one to the other; a pair whose distance is 0 has none, and is left out. So is one that is in `excluded`: what is
//   near at rest (rest_neighbours).
//
// repulse: a contact stops what approaches, and pushes as a spring does,
//
//   gain of the normal speed s = max(-s, 0) + max(min(dt k d mean(1/m_i), .1 d/dt - max(s, 0)), 0),  d = h - distance
//
//   so that a step undoes a tenth of the overlap at most; with friction (respond.h). No contact attracts. Positions
//   stay what they are: weights and normals are those at which the pairs were measured.
//
//   original  one contact after another, in order, each from the velocities that the one before has left
//   batches   likewise, in the order of first-fit batches (contact_batches.h)
//   jacobi    all from the velocities at the start. A vertex adds up its impulses in the order of contacts, from 0. The
//             impulse of a contact whose normal speed the sum would raise by more than its gain is multiplied by gain /
//             rise; the sum is made again.
//
// In:      topology; pairs, each kind in ascending order; excluded, likewise; position, m. thickness, m. contact: its
//          stiffness in N/m. inverse_mass, 1/kg, 0 of a vertex that is held. time_step, s.
// In, out: velocity, m/s, one for each inverse mass.
// Out:     contacts, resized; `distance` in normal[4 k + 3].
// Errors:  std::bad_alloc.
// Source:  Bridson, Fedkiw and Anderson 2002, section 7.2; jacobi's damping: the public source of PhysBAM,
//          TRIANGLE_REPULSIONS.
#pragma once

#include <cstdint>

#include "common/production_cloth/contacts.h"
#include "common/production_cloth/elements.h"
#include "common/production_cloth/respond.h"

namespace lockstep::production_cloth {

template <class Real>
using NearContacts = void(const Topology& topology, const ElementPairs& pairs, const ElementPairs& excluded,
                          const Vectors<Real>& position, Real thickness, Contacts<Real>& contacts);

template <class Real>
using Repulse = void(const Contacts<Real>& contacts, const Contact& contact, const Array<Real>& inverse_mass,
                     Real time_step, Vectors<Real>& velocity);

namespace serial {
NearContacts<float> near_contacts;
NearContacts<double> near_contacts;
Repulse<float> repulse_original, repulse_batches, repulse_jacobi;
Repulse<double> repulse_original, repulse_batches, repulse_jacobi;
}  // namespace serial

namespace openmp {
NearContacts<float> near_contacts;
Repulse<float> repulse_batches, repulse_jacobi;
}  // namespace openmp

// The pairs nearer than `distance`: at rest, what never repels.
template <class Real>
ElementPairs rest_neighbours(const Topology& topology, const ElementPairs& pairs, const Vectors<Real>& rest,
                             Real distance) {
  ElementPairs near;
  const auto corners = [&](const std::array<std::int32_t, 4>& v, Vector3<Real>(&x)[4]) {
    for (int i = 0; i < 4; ++i) x[i] = load(rest, v[i]);
  };
  Vector3<Real> x[4];
  for (const ElementPair& pair : pairs.point_triangle) {
    corners(corners_of_point_triangle(topology, pair), x);
    if (closest_of_point_triangle(x).square < distance * distance) near.point_triangle.push_back(pair);
  }
  for (const ElementPair& pair : pairs.edge_edge) {
    corners(corners_of_edge_edge(topology, pair), x);
    if (closest_of_edge_edge(x).square < distance * distance) near.edge_edge.push_back(pair);
  }
  return near;
}

}  // namespace lockstep::production_cloth
