// Pairs of elements, by number.
#pragma once

#include <compare>
#include <cstdint>
#include <vector>

namespace lockstep::spatial {

struct Pair {
  std::int32_t a, b;  // a < b
  auto operator<=>(const Pair&) const = default;
};

inline Pair make_pair(std::int32_t i, std::int32_t j) { return i < j ? Pair{i, j} : Pair{j, i}; }

using Pairs = std::vector<Pair>;

}  // namespace lockstep::spatial
