// Sorts bounded elements by a key, in parallel.
//
// A radix sort from the lowest digit up; each pass is a stable counting sort by one digit (openmp/counting_sort.h).
// Keys, passes and order are one parallel region, because starts of regions and barriers are what short sorts wait for.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "common/math.h"
#include "common/simd.h"
#include "common/spatial/bounds.h"
#include "openmp/counting_sort.h"
#include "openmp/spatial/boxes.h"
#include "openmp/spatial/workspace.h"

namespace lockstep::spatial::openmp {

// The bits of an unsigned integer in the order of the numbers; -0 counts as 0. Of a number or of lanes.
template <class Number>
inline auto key_of(const Number& x) {
  const auto bits = bits_of(x + Number(0.f));
  return bits ^ (bits >> 31 | std::numeric_limits<std::int32_t>::min());
}

inline constexpr int digit_bits = 8, digits = 1 << digit_bits;

// Puts `mine` and the other threads' elements of `from` in the order of the lowest `bits` bits of their keys; equal
// ones keep their order. Every thread of a team calls it, with a sort of `digits` keys and the same pointers. At its
// end, which is a barrier, `from` is what is sorted, and `to` the other array.
inline void sort_by_digits(lockstep::openmp::CountingSort& sort, lockstep::openmp::Share mine, int bits, Keyed*& from,
                           Keyed*& to) {
  for (int shift = 0; shift < bits; shift += digit_bits) {
    sort(
        [=, from = from](const auto& visit) {
          for (int i = mine.begin; i < mine.end; ++i) visit(from[i], from[i].key >> shift & (digits - 1));
        },
        [=, to = to](const Keyed& element, int place) { to[place] = element; });
    std::swap(from, to);
    // Each thread has moved its own elements; from here on the others read them.
#pragma omp barrier
  }
}

// Puts the bounded elements in the order of their keys, equal ones by number. key(i) has the keys of elements i to
// i + 15, unsigned and less than 2^bits - 1. Out: order, resized; returns the same with the keys, which the next call
// overwrites.
template <class Key>
std::span<const Keyed> sort_by_key(const Bounds<float>& bounds, int bits, const Key& key,
                                   std::vector<std::int32_t>& order) {
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
    for (int i = mine.begin; i < mine.end; i += lanes) {
      alignas(array_alignment) std::int32_t keys[lanes];
      store(keys, select(bounded(load_boxes(bounds, i)), key(i), static_cast<std::int32_t>(last)));
      for (int l = 0; l < std::min(lanes, mine.end - i); ++l)
        from[i + l] = {static_cast<std::uint32_t>(keys[l]), i + l};
    }
    sort_by_digits(sort, mine, bits, from, to);
    for (int k = mine.begin; k < mine.end; ++k) order[k] = from[k].element;
  }
  if ((bits + digit_bits - 1) / digit_bits % 2 == 1) keyed.swap(other);
  while (n > 0 && keyed[n - 1].key == last) --n;
  order.resize(n);
  return {keyed.data(), static_cast<std::size_t>(n)};
}

}  // namespace lockstep::spatial::openmp
