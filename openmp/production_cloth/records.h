// Vectors of vertices as records of four numbers, x, y, z and 0, which lanes load whole; and what elements give to
// their corners, stored in such records, which vertices then add up.
#pragma once

#include <span>

#include "common/production_cloth/cloth.h"
#include "common/production_cloth/elastic.h"
#include "common/production_cloth/element_forces.h"
#include "common/simd_records.h"
#include "openmp/vector_lanes.h"

namespace lockstep::production_cloth::openmp {

LOCKSTEP_INLINE Vector3<floatv> load_records_at(const float* records, const std::int32_t* index) {
  const Quads quads = load_quads(records, index);
  return {quads.field[0], quads.field[1], quads.field[2]};
}

// Sixteen records one after another.
LOCKSTEP_INLINE void store_sixteen(float* to, const Vector3<floatv>& v, floatv fourth = 0.f) {
  store_sixteen_quads(to, {{v.x, v.y, v.z, fourth}});
}
LOCKSTEP_INLINE Vector3<floatv> load_sixteen(const float* from) {
  const Quads quads = load_sixteen_quads(from);
  return {quads.field[0], quads.field[1], quads.field[2]};
}

// Corner c of a block's elements is record 16 c and the fifteen behind it.
template <int corners>
LOCKSTEP_INLINE void store_parts(const Parts<floatv, corners>& parts, float* records) {
  for (int c = 0; c < corners; ++c) store_sixteen(records + 4 * lanes * c, parts.of[c]);
}

// Adds up the parts of a slice's vertices, in their order.
LOCKSTEP_INLINE Vector3<floatv> add_parts(const Slices& corners_at, const float* records, int slice,
                                          Vector3<floatv> sum) {
  for (int item = corners_at.first[slice]; item < corners_at.first[slice + 1]; ++item)
    sum = sum + load_records_at(records, &corners_at.at[lanes * static_cast<std::size_t>(item)]);
  return sum;
}

LOCKSTEP_INLINE Vector3<floatv> load_fields(const Blocked<float>& array, int block, int field) {
  return {load(array.vector(block, field)), load(array.vector(block, field + 1)), load(array.vector(block, field + 2))};
}
LOCKSTEP_INLINE void store_fields(Blocked<float>& array, int block, int field, const Vector3<floatv>& v) {
  store(array.vector(block, field), v.x), store(array.vector(block, field + 1), v.y);
  store(array.vector(block, field + 2), v.z);
}

// Where the parts of a block's membranes begin.
inline std::size_t membrane_parts(int block) { return 4 * lanes * 3 * static_cast<std::size_t>(block); }

// Room for them, and for pushes; the last is 0.
inline Array<float> make_parts(const Elements<float>& elements) {
  return Array<float>(elements.membranes > 0 ? 4 * static_cast<std::size_t>(elements.last_place() + 1) : 0);
}
inline Array<float> make_pushes(const Elements<float>& elements) {
  return Array<float>(elements.facets > 0 ? static_cast<std::size_t>(elements.last_place() + 1) : 0);
}
inline Array<float> make_records(const Elements<float>& elements) {
  return Array<float>(numbers_of_records(elements.vertices));
}

// Positions as records. Called by all threads of a team.
inline void pack(const Elements<float>& elements, const Vectors<float>& position, Array<float>& records) {
  const Vector3<const float*> x = pointers(position);
  // A slice writes its own records.
#pragma omp for schedule(static)
  for (int slice = 0; slice < elements.slices(); ++slice)
    store_sixteen(&records[4 * lanes * static_cast<std::size_t>(slice)], load(x, lanes * slice));
}

// Calls f(has_springs, has_bending), as constants, so that loops hold no branches.
template <class F>
void with_links_of(const Elements<float>& elements, const F& f) {
  using Yes = std::true_type;
  using No = std::false_type;
  if (elements.has_springs && elements.has_bending) f(Yes(), Yes());
  if (elements.has_springs && !elements.has_bending) f(Yes(), No());
  if (!elements.has_springs && elements.has_bending) f(No(), Yes());
  if (!elements.has_springs && !elements.has_bending) f(No(), No());
}

}  // namespace lockstep::production_cloth::openmp
