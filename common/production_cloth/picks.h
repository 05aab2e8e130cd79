// Where sixteen lanes find their numbers in vectors of vertices.
//
// Vertices stand along a Morton curve (load_scene), and triangles by their least vertex. So sixteen neighbours of a
// slice's vertices are in four slices on the average, and seldom in more than six; and likewise what triangles give.
// If one instruction picks from two vectors (picks_from_vectors), loading these whole and picking from them takes less
// time than sixteen loads. Any mesh will do, but picking takes longer if what lanes want is in many vectors. Without
// such an instruction, each lane loads its number by itself.
//
// Made once, by sequential code.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "common/array.h"
#include "common/simd_records.h"

namespace lockstep::production_cloth {

inline constexpr int slice_vectors = 3;  // vectors of lanes in a slice of sixteen vertices: x, y and z

// `together` sixteens are a group and share the vectors that they load. Vectors are loaded in pairs, and each group has
// at least `pairs` pairs, which suffice for most; so the loops over these have a constant length.
template <int together, int pairs>
struct Picks {
  // If picks_from_vectors; else empty:
  Array<std::int32_t> first;   // [group]: its first vector in `vector`; and, behind the last group, their number
  Array<std::int32_t> vector;  // where each begins, counted in sixteens
  Array<std::uint16_t> place;  // [16 sixteen + lane]: 16 v + the lane, in v of its group's vectors
  // If not; else empty:
  Array<std::int32_t> at;  // [16 sixteen + lane]: the index of the number, for vectors of vertices that of x
};

// at: sixteens of what lanes want: 16 u + l is lane l of what begins at vector u * size. first_of(group) is the u that
// comes first.
template <int together, int pairs, class FirstOf>
Picks<together, pairs> make_picks(std::span<const std::int32_t> at, int size, const FirstOf& first_of) {
  constexpr std::size_t wanted = together * lanes;
  Picks<together, pairs> picks;
  if (!picks_from_vectors) {
    for (const std::int32_t k : at) picks.at.push_back(lanes * size * (k / lanes) + k % lanes);
    return picks;
  }
  picks.first.push_back(0);
  for (std::size_t begin = 0; begin < at.size(); begin += wanted) {
    const std::size_t first = picks.vector.size();
    const auto own = [&] { return std::span(picks.vector).subspan(first); };
    picks.vector.push_back(size * first_of(begin / wanted));
    for (const std::int32_t k : at.subspan(begin, wanted)) {
      const std::int32_t vector = size * (k / lanes);
      const auto v = std::ranges::find(own(), vector) - own().begin();
      if (v == std::ssize(own())) picks.vector.push_back(vector);
      picks.place.push_back(static_cast<std::uint16_t>(lanes * v + k % lanes));
    }
    while (own().size() < 2 * pairs || own().size() % 2 != 0) picks.vector.push_back(picks.vector[first]);
    picks.first.push_back(static_cast<std::int32_t>(picks.vector.size()));
  }
  return picks;
}

}  // namespace lockstep::production_cloth
