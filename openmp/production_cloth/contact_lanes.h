// Sixteen contacts at once, and the vertices that they touch, as records of four numbers: one access a vertex.
#pragma once

#include <memory>

#include "common/production_cloth/contacts.h"
#include "common/production_cloth/respond.h"
#include "common/simd_records.h"
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

LOCKSTEP_INLINE lockstep::Quads load_quads(const Quad* records, const Places& places) {
  return lockstep::load_quads(reinterpret_cast<const float*>(records), places.place);
}
LOCKSTEP_INLINE void store_quads(Quad* records, const Places& places, const lockstep::Quads& quads, maskv mask) {
  lockstep::store_quads(reinterpret_cast<float*>(records), places.place, quads, mask);
}
inline constexpr Places consecutive = {{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15}};

// A record of each vertex: its vector and its inverse mass. By the whole team; n is a multiple of sixteen. A barrier
// follows.
inline void make_records(const Vectors<float>& vectors, const Array<float>& inverse_mass, Quad* records) {
  const Vector3<const float*> from = pointers(vectors);
  const int n = static_cast<int>(inverse_mass.size());
  // Sixteen records are one thread's.
#pragma omp for schedule(static)
  for (int v = 0; v < n; v += lanes) {
    const Vector3<floatv> x = load(from, v);
    store_sixteen_quads(records[v].field, {{x.x, x.y, x.z, load(&inverse_mass[v])}});
  }
}

// The vectors of records, likewise.
inline void read_records(const Quad* records, Vectors<float>& vectors) {
  const Vector3<float*> to = pointers(vectors);
  const int n = static_cast<int>(vectors.x.size());
  // Sixteen vectors are one thread's.
#pragma omp for schedule(static)
  for (int v = 0; v < n; v += lanes) {
    const auto [x, y, z, w] = load_sixteen_quads(records[v].field).field;
    store(to, v, {x, y, z});
  }
}

// Contacts in lanes, and where the records of their vertices are.
struct Lanes16 {
  Touching<floatv> contact;
  Places corner[4];
};

// Contacts first + which[l].
LOCKSTEP_INLINE Lanes16 load_contacts(const Contacts<float>& contacts, int first, const std::int32_t* which,
                                      const Quad* records) {
  const std::size_t at = 4 * static_cast<std::size_t>(first);
  Lanes16 l;
  const lockstep::Quads corner =
      lockstep::load_quads(reinterpret_cast<const float*>(contacts.corner.data() + at), which);
  for (int i = 0; i < 4; ++i) {
    l.corner[i] = places_of(bits_of(corner.field[i]));
    const auto [x, y, z, inverse_mass] = load_quads(records, l.corner[i]).field;
    l.contact.velocity[i] = {x, y, z}, l.contact.inverse_mass[i] = inverse_mass;
  }
  const lockstep::Quads weight = lockstep::load_quads(contacts.weight.data() + at, which);
  for (int i = 0; i < 4; ++i) l.contact.weight[i] = weight.field[i];
  const auto [x, y, z, distance] = lockstep::load_quads(contacts.normal.data() + at, which).field;
  l.contact.normal = {x, y, z}, l.contact.distance = distance;
  return l;
}

// Contacts first .. first + 15; beyond the last one, that again.
LOCKSTEP_INLINE Lanes16 load_sixteen(const Contacts<float>& contacts, int first, const Quad* records) {
  const int last = static_cast<int>(contacts.count) - 1 - first;
  if (last >= lanes - 1) return load_contacts(contacts, first, consecutive.place, records);
  return load_contacts(contacts, first, places_of(min(lane_index(), intv(last))).place, records);
}

}  // namespace lockstep::production_cloth::openmp
