// Folding triangles, sixteen at once; and what they push with, which vertices then add up.
#pragma once

#include <array>
#include <span>

#include "openmp/production_cloth/records.h"

namespace lockstep::production_cloth::openmp {

// Where a block's triangles have what they have for corner c, or for the side opposite to it.
inline std::size_t corner_place(int block, int c) { return lanes * (3 * static_cast<std::size_t>(block) + c); }

// Where a block's records of a normal and a size begin.
inline std::size_t facet_records(int block) { return 4 * lanes * static_cast<std::size_t>(block); }

LOCKSTEP_INLINE Vector3<floatv> normals_of(const Quads& facets) {
  return {facets.field[0], facets.field[1], facets.field[2]};
}

// Where lanes find what a block's triangles have for corner c.
struct OfBlock {
  int block;
  floatv numbers(std::span<const float> from, int c) const { return load(&from[corner_place(block, c)]); }
  const std::int32_t* indices(std::span<const std::int32_t> from, int c) const { return &from[corner_place(block, c)]; }
};

// A triangle's three places, in each of sixteen lanes.
struct AtPlaces {
  std::int32_t place[3][lanes];
  floatv numbers(std::span<const float> from, int c) const { return load_each(from.data(), place[c]); }
  std::array<std::int32_t, lanes> indices(std::span<const std::int32_t> from, int c) const {
    std::array<std::int32_t, lanes> of_lanes;
    for (int l = 0; l < lanes; ++l) of_lanes[l] = from[place[c][l]];
    return of_lanes;
  }
};

// What sixteen triangles push their corners with; keep(c, resistance) is called for side c. x: positions of corners;
// own: normals and sizes.
template <class At, class Keep>
LOCKSTEP_INLINE Sides<floatv> pushes_of_facets(const Elements<float>& elements, const State<float>& state,
                                               const std::array<Vector3<floatv>, 3>& x, const Quads& own, const At& at,
                                               const Keep& keep) {
  const auto& [x0, x1, x2] = x;
  const auto torque = [&](int c, const Vector3<floatv>& e) {
    const Quads beside = load_quads(state.normals.data(), &at.indices(elements.facet_beside, c)[0]);
    const Resistance<floatv> hinge =
        resistance_of_hinge(floatv(elements.hinge_stiffness), at.numbers(elements.rest_sine_at, c),
                            at.numbers(elements.root_of_damping_at, c), normals_of(own), own.field[3],
                            normals_of(beside), beside.field[3], e);
    keep(c, hinge.of_rate);
    return hinge.torque;
  };
  const floatv cotangents[] = {at.numbers(state.cotangents, 0), at.numbers(state.cotangents, 1),
                               at.numbers(state.cotangents, 2)};
  return pushes_of_facet(cotangents, {torque(0, x2 - x1), torque(1, x0 - x2), torque(2, x1 - x0)});
}

// The normals of the triangles at item k of corners_at.
LOCKSTEP_INLINE Vector3<floatv> gather_normals(const Elements<float>& elements, const State<float>& state,
                                               std::size_t k) {
  return load_records_at(state.normals.data(), &elements.facet_at[lanes * k]);
}

// The same normals. The first product of a solve gathers them and keeps them at item k; later products load them there.
template <bool is_first>
LOCKSTEP_INLINE Vector3<floatv> normals_at(const Elements<float>& elements, const State<float>& state, std::size_t k,
                                           std::span<float> kept) {
  float* const normal = &kept[3 * lanes * k];
  if constexpr (!is_first) return {load(normal), load(normal + lanes), load(normal + 2 * lanes)};
  const Vector3<floatv> gathered = gather_normals(elements, state, k);
  store(normal, gathered.x), store(normal + lanes, gathered.y), store(normal + 2 * lanes, gathered.z);
  return gathered;
}

// Adds up what triangles push a slice's vertices with, in their order, for several arrays of pushes, by place.
// normals(k): of the triangles at item k.
template <std::size_t count, class Normals>
LOCKSTEP_INLINE void add_pushes(const Slices& at, const std::array<std::span<const float>, count>& pushes, int slice,
                                const Normals& normals, std::array<Vector3<floatv>, count>& sums) {
  for (std::size_t k = at.first[slice]; k < std::size_t(at.first[slice + 1]); ++k) {
    const Vector3<floatv> normal = normals(k);
    for (std::size_t p = 0; p < count; ++p) sums[p] = sums[p] + load_each(pushes[p].data(), &at.at[lanes * k]) * normal;
  }
}

}  // namespace lockstep::production_cloth::openmp
