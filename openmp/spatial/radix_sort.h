// Sorts bounded elements by a key, in parallel.
//
// A radix sort from the lowest digit up; each pass is a stable counting sort by one digit (openmp/counting_sort.h).
// Keys, passes and order are one parallel region, because starts of regions and barriers are what short sorts wait for.
#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "common/spatial/bounds.h"
#include "openmp/counting_sort.h"
#include "openmp/spatial/workspace.h"

namespace lockstep::spatial::openmp {

// An integer in the order of the numbers; -0 counts as 0.
inline std::uint32_t key_of(float x) {
  const auto bits = std::bit_cast<std::uint32_t>(x + 0.f);
  return bits ^ (static_cast<std::uint32_t>(static_cast<std::int32_t>(bits) >> 31) | 0x80000000u);
}

// Puts the bounded elements in the order of key(element) < 2^bits - 1, equal ones by number. Out: order, resized;
// returns the same with the keys, which the next call overwrites.
template <class Key>
std::span<const Keyed> sort_by_key(const Bounds<float>& bounds, int bits, const Key& key,
                                   std::vector<std::int32_t>& order) {
  constexpr int digit_bits = 8, digits = 1 << digit_bits;
  const std::uint32_t last = static_cast<std::uint32_t>((std::uint64_t{1} << bits) - 1);
  Array<Keyed>&keyed = workspace().radix_sort.keyed, &other = workspace().radix_sort.other;
  int n = bounds.count;
  grow(keyed, n);
  grow(other, n);
  order.resize(n);
  lockstep::openmp::CountingSort sort(digits);

  // Each thread reads and writes its own share of keys and order, and moves where the sort tells it; the barriers stand
  // between one thread's writing and another's reading.
#pragma omp parallel
  {
    const lockstep::openmp::Share mine = lockstep::openmp::my_share(n);
    Keyed *from = keyed.data(), *to = other.data();
    for (int i = mine.begin; i < mine.end; ++i) {
      from[i] = {bounds.bounded(i) ? static_cast<std::uint32_t>(key(i)) : last, i};
    }
    for (int shift = 0; shift < bits; shift += digit_bits) {
      sort(
          [=](const auto& visit) {
            for (int i = mine.begin; i < mine.end; ++i) visit(from[i], from[i].key >> shift & (digits - 1));
          },
          [=](const Keyed& element, int place) { to[place] = element; });
      std::swap(from, to);
#pragma omp barrier
    }
    for (int k = mine.begin; k < mine.end; ++k) order[k] = from[k].element;
  }
  if ((bits + digit_bits - 1) / digit_bits % 2 == 1) keyed.swap(other);
  while (n > 0 && keyed[n - 1].key == last) --n;
  order.resize(n);
  return {keyed.data(), static_cast<std::size_t>(n)};
}

}  // namespace lockstep::spatial::openmp
