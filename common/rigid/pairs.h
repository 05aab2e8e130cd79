// Pairs of colliders, as all broad phases find them.
#pragma once

#include <compare>
#include <cstdint>
#include <vector>

namespace lockstep::rigid {

struct Pair {
  std::int32_t a, b;  // a < b
  auto operator<=>(const Pair&) const = default;
};

inline Pair make_pair(std::int32_t i, std::int32_t j) { return i < j ? Pair{i, j} : Pair{j, i}; }

// What a broad phase finds: every pair of bounded colliders whose boxes overlap, or touch, and whose groups differ, once, in the order of a
// and then b. Colliders without bounds (planes) are left to plane_pairs.
using Pairs = std::vector<Pair>;

}  // namespace lockstep::rigid
