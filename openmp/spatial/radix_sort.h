// Sorts colliders by a key, in parallel.
//
// A radix sort from the lowest digit up. In each pass threads count the digits of their shares; from the counts of all, each knows where
// each of its elements goes. Shares are contiguous and taken in order, so that every pass, and with it the sort, is stable, whatever the
// number of threads. Keys, passes and order are one parallel region, for starts of regions and barriers
// are what short sorts wait for.
//
// Source: as openmp/fluid/rebuild_grid.cpp; Satish, Harris and Garland, Designing Efficient Sorting Algorithms for Manycore GPUs (2009).
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "common/spatial/bounds.h"
#include "openmp/spatial/workspace.h"
#include "openmp/share.h"

namespace lockstep::spatial::openmp {

// In the order of the numbers; -0 as 0.
inline std::uint32_t key_of(float x) {
  const auto bits = std::bit_cast<std::uint32_t>(x + 0.f);
  return bits ^ (static_cast<std::uint32_t>(static_cast<std::int32_t>(bits) >> 31) | 0x80000000u);
}

// Threads' counts of the elements of their shares, by digit.
template <std::size_t digits>
using Counts = Array<std::array<std::int32_t, digits>>;  // [thread][digit]

// Where a thread's first element of each digit goes: behind all of lesser digits, and behind those of the threads before it.
template <std::size_t digits>
std::array<std::int32_t, digits> places(const Counts<digits>& counts, int thread) {
  std::array<std::int32_t, digits> all = {}, place = {};
  for (int t = 0; t < omp_get_num_threads(); ++t) {
    if (t == thread) place = all;
    for (std::size_t digit = 0; digit < digits; ++digit) all[digit] += counts[t][digit];
  }
  std::int32_t lesser = 0;
  for (std::size_t digit = 0; digit < digits; ++digit) place[digit] += std::exchange(lesser, lesser + all[digit]);
  return place;
}

// The colliders that have bounds, in the order of key(collider) < 2^bits - 1, equal ones by number; in order[k].
template <class Key>
std::span<const Keyed> sort_by_key(const Bounds<float>& bounds, int bits, const Key& key, std::vector<std::int32_t>& order) {
  constexpr int digit_bits = 8, digits = 1 << digit_bits;
  const std::uint32_t last = static_cast<std::uint32_t>((std::uint64_t{1} << bits) - 1);
  Array<Keyed>&keyed = workspace().radix_sort.keyed, &other = workspace().radix_sort.other;
  int n = bounds.count;
  grow(keyed, n);
  grow(other, n);
  order.resize(n);
  Counts<digits> counts(omp_get_max_threads());

  // Each thread counts and moves its own share, and adds up all counts for itself; the barriers stand between one thread's writing and
  // another's reading.
#pragma omp parallel
  {
    const lockstep::openmp::Share mine = lockstep::openmp::my_share(n);
    const int thread = omp_get_thread_num();
    Keyed *from = keyed.data(), *to = other.data();
    for (int i = mine.begin; i < mine.end; ++i) from[i] = {bounds.bounded(i) ? static_cast<std::uint32_t>(key(i)) : last, i};
    for (int shift = 0; shift < bits; shift += digit_bits) {
      std::array<std::int32_t, digits> count = {};
      for (int i = mine.begin; i < mine.end; ++i) ++count[from[i].key >> shift & (digits - 1)];
      counts[thread] = count;
#pragma omp barrier
      std::array<std::int32_t, digits> place = places(counts, thread);
      for (int i = mine.begin; i < mine.end; ++i) to[place[from[i].key >> shift & (digits - 1)]++] = from[i];
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
