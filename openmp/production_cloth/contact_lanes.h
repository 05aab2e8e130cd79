// Sixteen contacts at once, and the vertices that they touch, as records of four numbers: one access a vertex.
#pragma once

#include <memory>

#include "common/production_cloth/contacts.h"
#include "common/production_cloth/respond.h"
#include "common/simd.h"
#include "openmp/vector_lanes.h"

namespace lockstep::production_cloth::openmp {

struct alignas(16) Quad {
  float field[4];
};

// The indices of sixteen records.
struct Places {
  alignas(array_alignment) std::int32_t place[lanes];
};
LOCKSTEP_INLINE Places places_of(intv place) {
  Places places;
  store(places.place, place);
  return places;
}
LOCKSTEP_INLINE Places places_from(int first) { return places_of(intv(first) + lane_index()); }

LOCKSTEP_INLINE lockstep::Quads load_quads(const Quad* records, const Places& places) {
  return lockstep::load_quads(reinterpret_cast<const float*>(records), places.place);
}
LOCKSTEP_INLINE void store_quads(Quad* records, const Places& places, const lockstep::Quads& quads, maskv mask) {
  lockstep::store_quads(reinterpret_cast<float*>(records), places.place, quads, mask);
}

// A record of each vertex: its vector and its inverse mass. By the whole team; n is a multiple of sixteen. A barrier
// follows.
inline void make_records(const Vectors<float>& vectors, const Array<float>& inverse_mass, Quad* records) {
  const Vector3<const float*> from = pointers(vectors);
  const int n = static_cast<int>(inverse_mass.size());
  // Sixteen records are one thread's.
#pragma omp for schedule(static)
  for (int v = 0; v < n; v += lanes) {
    const Vector3<floatv> x = load(from, v);
    store_quads(records, places_from(v), {{x.x, x.y, x.z, load(&inverse_mass[v])}}, lanes_of(0xffff));
  }
}

// The vectors of records, likewise.
inline void read_records(const Quad* records, Vectors<float>& vectors) {
  const Vector3<float*> to = pointers(vectors);
  const int n = static_cast<int>(vectors.x.size());
  // Sixteen vectors are one thread's.
#pragma omp for schedule(static)
  for (int v = 0; v < n; v += lanes) {
    const auto [x, y, z, w] = load_quads(records, places_from(v)).field;
    store(to, v, {x, y, z});
  }
}

// Contacts in lanes, and where the records of their vertices are.
struct Lanes16 {
  Touching<floatv> contact;
  Places corner[4];
};

LOCKSTEP_INLINE Lanes16 load_contacts(const Contacts<float>& contacts, const Places& places, const Quad* records) {
  Lanes16 l;
  const intv first = load(places.place) * 4;
  for (int i = 0; i < 4; ++i) {
    l.corner[i] = places_of(gather(contacts.corner.data() + i, first));
    const auto [x, y, z, inverse_mass] = load_quads(records, l.corner[i]).field;
    l.contact.velocity[i] = {x, y, z}, l.contact.inverse_mass[i] = inverse_mass;
  }
  const lockstep::Quads weight = lockstep::load_quads(contacts.weight.data(), places.place);
  for (int i = 0; i < 4; ++i) l.contact.weight[i] = weight.field[i];
  const auto [x, y, z, distance] = lockstep::load_quads(contacts.normal.data(), places.place).field;
  l.contact.normal = {x, y, z}, l.contact.distance = distance;
  return l;
}

}  // namespace lockstep::production_cloth::openmp
