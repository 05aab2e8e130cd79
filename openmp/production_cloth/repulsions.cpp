// Elements of a cloth that are near each other are kept apart by impulses.
//
// Sixteen pairs at once. Pairs are first told near or not, then those that are near are measured again and written
// where they belong (openmp/compaction.h): few are, and no thread waits for another to know its place. Contacts are
// answered in batches or all at once (respond_in_order.h).
//
// The contract stands in common/production_cloth/repulsions.h.
#include "common/production_cloth/repulsions.h"

#include <algorithm>
#include <bit>

#include "common/real.h"
#include "openmp/compaction.h"
#include "openmp/production_cloth/respond_in_order.h"

namespace lockstep::production_cloth::openmp {
namespace {

using Number = floatv;

// Sixteen pairs, and their vertices. Lanes beyond the last pair repeat it.
struct PairLanes {
  Places corner[4];
  Vector3<Number> x[4];
};

template <class CornersOf>
LOCKSTEP_INLINE PairLanes load_pairs(const Array<ElementPair>& pairs, int i, const Quad* position,
                                     const CornersOf& corners_of) {
  PairLanes p;
  for (int l = 0; l < lanes; ++l) {
    const std::array<std::int32_t, 4> corner = corners_of(pairs[std::min(i + l, static_cast<int>(pairs.size()) - 1)]);
    for (int c = 0; c < 4; ++c) p.corner[c].place[l] = corner[c];
  }
  for (int c = 0; c < 4; ++c) {
    const auto [x, y, z, w] = load_quads(position, p.corner[c]).field;
    p.x[c] = {x, y, z};
  }
  return p;
}

// Which of some pairs are excluded, a bit a pair. `next` is the first that is not before them, and moves on.
std::uint32_t excluded_of(std::uint32_t which, const ElementPair* pairs, const ElementPair* end,
                          const ElementPair*& next) {
  std::uint32_t found = 0;
  for (; which != 0; which &= which - 1) {
    const int l = std::countr_zero(which);
    while (next != end && *next < pairs[l]) ++next;
    found |= std::uint32_t(next != end && *next == pairs[l]) << l;
  }
  return found;
}

// Adds the pairs of one kind that are nearer than the thickness.
template <class CornersOf, class ClosestOf>
void add_near(const Array<ElementPair>& pairs, const Array<ElementPair>& excluded, const Quad* position, Real thickness,
              const CornersOf& corners_of, const ClosestOf& closest_of, Contacts<Real>& contacts) {
  lockstep::openmp::Compaction near(static_cast<int>(pairs.size()));
  // A chunk's pairs are one thread's.
#pragma omp parallel for schedule(static)
  for (int chunk = 0; chunk < near.chunks(); ++chunk) {
    const ElementPair* const end = excluded.data() + excluded.size();
    const ElementPair* next = std::lower_bound(excluded.data(), end, pairs[chunk * near.chunk_size]);
    near.for_each_sixteen(chunk, [&](int i) {
      const Closest<Number> closest = closest_of(load_pairs(pairs, i, position, corners_of).x);
      const maskv inside = first_lanes(static_cast<int>(pairs.size()) - i);
      const std::uint32_t which = bits(inside & (closest.square < thickness * thickness) & (closest.square > 0.f));
      near.choose(i, lanes_of(which & ~excluded_of(which, &pairs[i], end, next)));
    });
  }
  const int first = static_cast<int>(contacts.count);
  contacts.resize(first + near.add_up());
  // A pair that is near has a place of its own.
#pragma omp parallel for schedule(static)
  for (int chunk = 0; chunk < near.chunks(); ++chunk)
    near.for_each_sixteen(chunk, [&](int i) {
      if (near.which(i) == 0) return;
      const PairLanes p = load_pairs(pairs, i, position, corners_of);
      const Closest<Number> closest = closest_of(p.x);
      const Number distance = sqrt(closest.square);
      const Vector3<Number> normal = (1 / distance) * closest.difference;
      Places to;
      int k = first + near.before(i);
      for (int l = 0; l < lanes; ++l) {
        to.place[l] = k;
        if ((near.which(i) >> l & 1) == 0) continue;
        for (int c = 0; c < 4; ++c) contacts.corner[4 * static_cast<std::size_t>(k) + c] = p.corner[c].place[l];
        ++k;
      }
      const maskv chosen = lanes_of(near.which(i));
      const auto& weight = closest.weight;
      lockstep::store_quads(contacts.weight.data(), to.place, {{weight[0], weight[1], weight[2], weight[3]}}, chosen);
      lockstep::store_quads(contacts.normal.data(), to.place, {{normal.x, normal.y, normal.z, distance}}, chosen);
    });
}

}  // namespace

void near_contacts(const Topology& topology, const ElementPairs& pairs, const ElementPairs& excluded,
                   const Vectors<Real>& position, Real thickness, Contacts<Real>& contacts) {
  contacts.resize(0);
  const auto records = std::make_unique_for_overwrite<Quad[]>(position.x.size());
  // make_records shares vertices out to the team.
#pragma omp parallel
  make_records(position, position.x, records.get());
  const auto point_triangle = [&](const ElementPair& pair) { return corners_of_point_triangle(topology, pair); };
  const auto edge_edge = [&](const ElementPair& pair) { return corners_of_edge_edge(topology, pair); };
  add_near(pairs.point_triangle, excluded.point_triangle, records.get(), thickness, point_triangle,
           closest_of_point_triangle<Number>, contacts);
  add_near(pairs.edge_edge, excluded.edge_edge, records.get(), thickness, edge_edge, closest_of_edge_edge<Number>,
           contacts);
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

}  // namespace lockstep::production_cloth::openmp
