// Of which vectors sixteen lanes pick what they want.
//
// Vertices stand along a Morton curve (load_scene), so that sixteen neighbours of a slice's vertices are in four slices
// on the average, and seldom in more than six. To load these whole and to pick from them takes less time than to load
// sixteen records one by one. Any mesh will do: from many vectors it takes longer.
//
// Made once, by sequential code.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <type_traits>

#include "common/array.h"
#include "common/simd.h"

namespace lockstep::production_cloth {

// Picks of groups of so many sixteens, which share what vectors they load.
template <int together>
struct Picks {
  using Place = std::conditional_t<together == 1, std::uint8_t, std::uint16_t>;
  Array<std::int32_t> first;   // [group]: its first in `vector`; and the number of all. They are pairs, at least two
  Array<std::int32_t> vector;  // numbers of vectors
  Array<Place> place;          // [16 sixteen + lane]: 16 v + the lane, in v of its group's vectors
};

// at: sixteens of what lanes want, lane l of vector v as 16 v + l. first_of(group): the vector that comes first.
template <int together, class FirstOf>
Picks<together> make_picks(std::span<const std::int32_t> at, const FirstOf& first_of) {
  constexpr int size = together * lanes;
  Picks<together> picks;
  picks.first.push_back(0);
  for (std::size_t begin = 0; begin < at.size(); begin += size) {
    const std::size_t first = picks.vector.size();
    const auto own = [&] { return std::span(picks.vector).subspan(first); };
    picks.vector.push_back(first_of(begin / size));
    for (const std::int32_t k : at.subspan(begin, size)) {
      const auto found = std::ranges::find(own(), k / lanes);
      const auto v = found - own().begin();
      picks.place.push_back(static_cast<typename Picks<together>::Place>(lanes * v + k % lanes));
      if (found == own().end()) picks.vector.push_back(k / lanes);
    }
    while (own().size() < 4 || own().size() % 2 != 0) picks.vector.push_back(picks.vector[first]);
    picks.first.push_back(static_cast<std::int32_t>(picks.vector.size()));
  }
  return picks;
}

}  // namespace lockstep::production_cloth
