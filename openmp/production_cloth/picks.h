// Vectors of vertices by slices, and numbers by place: lanes load their own sixteen, and pick or load sixteen others.
#pragma once

#include <array>

#include "common/production_cloth/elastic.h"
#include "common/simd_records.h"
#include "openmp/vector_lanes.h"

namespace lockstep::production_cloth::openmp {

// A slice of vertices: three vectors of lanes, side by side.
LOCKSTEP_INLINE Vector3<floatv> load_three(const float* from) {
  return {load(from), load(from + lanes), load(from + 2 * lanes)};
}
LOCKSTEP_INLINE void store_three(float* to, const Vector3<floatv>& v) {
  store(to, v.x), store(to + lanes, v.y), store(to + 2 * lanes, v.z);
}

// Positions by slices. Called by all threads of a team.
inline void pack_slices(const Elements<float>& elements, const Vectors<float>& position, Array<float>& slices) {
  const Vector3<const float*> x = pointers(position);
  // A slice writes its own vectors.
#pragma omp for schedule(static)
  for (int slice = 0; slice < elements.slices(); ++slice)
    store_three(&slices[lanes * slice_vectors * static_cast<std::size_t>(slice)], load(x, lanes * slice));
}

LOCKSTEP_INLINE Vector3<floatv> choose(const Vector3<floatv>& a, const Vector3<floatv>& b, intv k) {
  return {lockstep::choose(a.x, b.x, k), lockstep::choose(a.y, b.y, k), lockstep::choose(a.z, b.z, k)};
}

// What a group's lanes want, from whole vectors. loaded(vector): what begins there; first: that of the group's first.
template <int together, int pairs, class Loaded, class T>
LOCKSTEP_INLINE std::array<T, together> pick(const Picks<together, pairs>& picks, std::size_t group, const T& first,
                                             const Loaded& loaded) {
  const std::int32_t* const vector = &picks.vector[picks.first[group]];
  const int vectors = picks.first[group + 1] - picks.first[group];
  std::array<intv, together> place;
  std::array<T, together> picked;
  const T second = loaded(vector[1]);
  for (int c = 0; c < together; ++c) {
    place[c] = load_wide(&picks.place[lanes * (together * group + c)]);
    picked[c] = choose(first, second, place[c]);
  }
  const auto pick_pair = [&](int v) __attribute__((always_inline)) {
    const T a = loaded(vector[v]), b = loaded(vector[v + 1]);
    for (int c = 0; c < together; ++c)
      picked[c] = select(place[c] >= intv(lanes * v), choose(a, b, place[c]), picked[c]);
  };
  for (int v = 2; v < 2 * pairs; v += 2) pick_pair(v);
  for (int v = 2 * pairs; v < vectors; v += 2) pick_pair(v);
  return picked;
}

// The indices of what sixteen c of a group wants.
template <int together, int pairs>
LOCKSTEP_INLINE const std::int32_t* indices(const Picks<together, pairs>& picks, std::size_t group, int c) {
  return &picks.at[lanes * (together * group + c)];
}

// Vectors of vertices. own: that of the group's first slice.
template <int together, int pairs>
LOCKSTEP_INLINE std::array<Vector3<floatv>, together> pick_vectors(const Picks<together, pairs>& picks,
                                                                   std::size_t group, const float* x,
                                                                   const Vector3<floatv>& own) {
  if constexpr (picks_from_vectors) {
    return pick(picks, group, own, [&](int vector) { return load_three(x + lanes * std::ptrdiff_t(vector)); });
  } else {
    std::array<Vector3<floatv>, together> picked;
    for (int c = 0; c < together; ++c) {
      const std::int32_t* const at = indices(picks, group, c);
      picked[c] = {load_each(x, at), load_each(x + lanes, at), load_each(x + 2 * lanes, at)};
    }
    return picked;
  }
}

// Of the corners of a block of triangles.
LOCKSTEP_INLINE std::array<Vector3<floatv>, 3> pick_corners(const Elements<float>& elements, const float* x,
                                                            int block) {
  const Picks<3, 2>& picks = elements.corner_picks;
  if constexpr (picks_from_vectors)
    return pick_vectors(picks, block, x, load_three(x + lanes * std::ptrdiff_t(picks.vector[picks.first[block]])));
  else
    return pick_vectors(picks, block, x, {});
}

template <int pairs>
LOCKSTEP_INLINE floatv pick_numbers(const Picks<1, pairs>& picks, std::size_t group, const float* from) {
  if constexpr (picks_from_vectors) {
    const auto loaded = [&](int vector) { return load(from + lanes * std::ptrdiff_t(vector)); };
    return pick(picks, group, loaded(picks.vector[picks.first[group]]), loaded)[0];
  } else {
    return load_each(from, indices(picks, group, 0));
  }
}

}  // namespace lockstep::production_cloth::openmp
