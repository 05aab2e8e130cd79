// Vectors of vertices by slices, of which lanes load their own sixteen or pick sixteen others.
#pragma once

#include <array>

#include "common/production_cloth/picks.h"
#include "common/simd_records.h"
#include "openmp/vector_lanes.h"

namespace lockstep::production_cloth::openmp {

// Vectors of vertices: of a slice three vectors of lanes, side by side.
constexpr int slice_floats = 3 * lanes;
LOCKSTEP_INLINE Vector3<floatv> load_slice(const float* x, int slice) {
  const float* const at = x + slice_floats * static_cast<std::size_t>(slice);
  return {load(at), load(at + lanes), load(at + 2 * lanes)};
}
LOCKSTEP_INLINE void store_slice(float* x, int slice, const Vector3<floatv>& v) {
  float* const at = x + slice_floats * static_cast<std::size_t>(slice);
  store(at, v.x), store(at + lanes, v.y), store(at + 2 * lanes, v.z);
}

LOCKSTEP_INLINE Vector3<floatv> choose(const Vector3<floatv>& a, const Vector3<floatv>& b, intv k) {
  return {lockstep::choose(a.x, b.x, k), lockstep::choose(a.y, b.y, k), lockstep::choose(a.z, b.z, k)};
}

// What a group's lanes want of x. first: of x, of the slice that comes first.
template <int together>
LOCKSTEP_INLINE std::array<Vector3<floatv>, together> pick(const Picks<together>& picks, std::size_t group,
                                                           const float* x, const Vector3<floatv>& first) {
  const std::int32_t* const vector = &picks.vector[picks.first[group]];
  const int vectors = picks.first[group + 1] - picks.first[group];
  std::array<intv, together> place;
  std::array<Vector3<floatv>, together> picked;
  const Vector3<floatv> second = load_slice(x, vector[1]);
  for (int c = 0; c < together; ++c) {
    place[c] = load_wide(&picks.place[lanes * (together * group + c)]);
    picked[c] = choose(first, second, place[c]);
  }
  int v = 2;
  do {
    const Vector3<floatv> a = load_slice(x, vector[v]), b = load_slice(x, vector[v + 1]);
    for (int c = 0; c < together; ++c)
      picked[c] = select(place[c] >= intv(lanes * v), choose(a, b, place[c]), picked[c]);
    v += 2;
  } while (v < vectors);
  return picked;
}

}  // namespace lockstep::production_cloth::openmp
