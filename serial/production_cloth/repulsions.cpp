// Elements of a cloth that are near each other are kept apart by impulses.
//
// Cloth is thin and has no inside: what has passed through itself cannot be told from what has not. So it is kept from
// coming close at all. A pair of elements that is nearer than the thickness stops approaching, and is pushed apart as
// by a spring. That is cheap, and leaves little to collisions, which must find when and where elements meet.
//
// One contact after another is the original order. Each sees what those before it have done, and undoes some of it.
// All at once, contacts that act on one vertex would each do the whole work, and together too much: so each steps
// back in proportion.
//
// The contract stands in common/production_cloth/repulsions.h.
#include "common/production_cloth/repulsions.h"

#include <algorithm>
#include <cmath>

#include "common/real.h"
#include "serial/production_cloth/respond_in_order.h"

namespace lockstep::production_cloth::serial {
namespace {

using Number = Real;

// Adds the pairs of one kind that are nearer than the thickness.
template <class CornersOf, class ClosestOf>
void add_near(const Array<ElementPair>& pairs, const Array<ElementPair>& excluded, const Vectors<Real>& position,
              Real thickness, const CornersOf& corners_of, const ClosestOf& closest_of, Contacts<Real>& contacts) {
  const ElementPair* const end = excluded.data() + excluded.size();
  const ElementPair* next = excluded.data();  // the first that is not before the pair
  for (const ElementPair& pair : pairs) {
    const std::array<std::int32_t, 4> corner = corners_of(pair);
    Vector3<Number> x[4];
    for (int i = 0; i < 4; ++i) x[i] = load(position, corner[i]);
    const Closest<Number> closest = closest_of(x);
    if (!(closest.square < thickness * thickness && closest.square > 0)) continue;
    while (next != end && *next < pair) ++next;
    if (next != end && *next == pair) continue;
    const Number distance = sqrt(closest.square);
    const Vector3<Number> normal = (1 / distance) * closest.difference;
    const std::size_t k = 4 * contacts.count;
    contacts.resize(contacts.count + 1);
    std::ranges::copy(corner, &contacts.corner[k]);
    std::ranges::copy(closest.weight, &contacts.weight[k]);
    std::ranges::copy(std::array{normal.x, normal.y, normal.z, distance}, &contacts.normal[k]);
  }
}

}  // namespace

void near_contacts(const Topology& topology, const ElementPairs& pairs, const ElementPairs& excluded,
                   const Vectors<Real>& position, Real thickness, Contacts<Real>& contacts) {
  contacts.resize(0);
  const auto point_triangle = [&](const ElementPair& pair) { return corners_of_point_triangle(topology, pair); };
  const auto edge_edge = [&](const ElementPair& pair) { return corners_of_edge_edge(topology, pair); };
  add_near(pairs.point_triangle, excluded.point_triangle, position, thickness, point_triangle,
           closest_of_point_triangle<Number>, contacts);
  add_near(pairs.edge_edge, excluded.edge_edge, position, thickness, edge_edge, closest_of_edge_edge<Number>, contacts);
}

void repulse_original(const Contacts<Real>& contacts, const Contact& contact, const Array<Real>& inverse_mass,
                      Real time_step, Vectors<Real>& velocity) {
  respond_in_order(contacts, gain_of_repulsion(contact, time_step), static_cast<Real>(contact.friction), inverse_mass,
                   velocity);
}

void repulse_batches(const Contacts<Real>& contacts, const Contact& contact, const Array<Real>& inverse_mass,
                     Real time_step, Vectors<Real>& velocity) {
  respond_in_batches(contacts, gain_of_repulsion(contact, time_step), static_cast<Real>(contact.friction), inverse_mass,
                     velocity);
}

void repulse_jacobi(const Contacts<Real>& contacts, const Contact& contact, const Array<Real>& inverse_mass,
                    Real time_step, Vectors<Real>& velocity) {
  respond_at_once(contacts, gain_of_repulsion(contact, time_step), static_cast<Real>(contact.friction), inverse_mass,
                  velocity);
}

}  // namespace lockstep::production_cloth::serial
