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

// Pairs are counted in int32. Half of its range leaves room for padding.
inline constexpr double max_pairs = 1 << 30;

// To be asked before an array of pairs grows from `room` pairs: throws InputError if `pairs` are more than max_pairs,
// or than fit the memory that is available.
void require_pairs_fit(double pairs, double room);

// Appends a pair. Throws as require_pairs_fit does.
template <class Pair, class Allocator>
void add_pair(std::vector<Pair, Allocator>& pairs, const Pair& pair) {
  const auto room = static_cast<double>(pairs.capacity());
  if (pairs.size() == pairs.capacity()) require_pairs_fit(2 * room, room);
  pairs.push_back(pair);
}

}  // namespace lockstep::spatial
