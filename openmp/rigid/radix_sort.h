// Sorts colliders by a key, in parallel.
//
// A radix sort from the lowest digit up. In each pass threads count the digits of their shares, the counts are summed by digit and within a
// digit by thread, and each thread then knows where each of its elements goes. Shares are contiguous and taken in order, so that every
// pass, and with it the sort, is stable, whatever the number of threads.
//
// Source: as openmp/fluid/rebuild_grid.cpp; Satish, Harris and Garland, Designing Efficient Sorting Algorithms for Manycore GPUs (2009).
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "common/rigid/bounds.h"
#include "openmp/rigid/workspace.h"
#include "openmp/share.h"

namespace lockstep::rigid::openmp {

// In the order of the numbers; -0 as 0.
inline std::uint32_t key_of(float x) {
  const auto bits = std::bit_cast<std::uint32_t>(x + 0.f);
  return bits ^ (static_cast<std::uint32_t>(static_cast<std::int32_t>(bits) >> 31) | 0x80000000u);
}

// Sorts n elements by the lowest `bits` bits of their keys; equal ones stay in order.
inline void radix_sort(int n, int bits, Array<Keyed>& keyed, Array<Keyed>& other) {
  constexpr int digit_bits = 8, digits = 1 << digit_bits;
  std::vector<std::array<std::int32_t, digits>> next(omp_get_max_threads());  // [thread][digit]

  // Each thread counts and moves its own share, with its own places; the barriers stand between one thread's writing and another's reading.
#pragma omp parallel
  {
    const lockstep::openmp::Share mine = lockstep::openmp::my_share(n);
    Keyed *from = keyed.data(), *to = other.data();
    for (int shift = 0; shift < bits; shift += digit_bits) {
      std::array<std::int32_t, digits> count = {};
      for (int i = mine.begin; i < mine.end; ++i) ++count[from[i].key >> shift & (digits - 1)];
      next[omp_get_thread_num()] = count;
#pragma omp barrier
#pragma omp single
      for (int digit = 0, sum = 0; digit < digits; ++digit)
        for (int thread = 0; thread < omp_get_num_threads(); ++thread) sum += std::exchange(next[thread][digit], sum);
      count = next[omp_get_thread_num()];
      for (int i = mine.begin; i < mine.end; ++i) to[count[from[i].key >> shift & (digits - 1)]++] = from[i];
      std::swap(from, to);
#pragma omp barrier
    }
  }
  if ((bits + digit_bits - 1) / digit_bits % 2 == 1) keyed.swap(other);
}

// The colliders that have bounds, in the order of key(collider) < 2^bits - 1, equal ones by number; in order[k].
template <class Key>
std::span<const Keyed> sort_by_key(const Bounds<float>& bounds, int bits, const Key& key, std::vector<std::int32_t>& order) {
  const std::uint32_t last = static_cast<std::uint32_t>((std::uint64_t{1} << bits) - 1);
  Array<Keyed>&keyed = workspace().radix_sort.keyed, &other = workspace().radix_sort.other;
  int n = bounds.count;
  grow(keyed, n);
  grow(other, n);
  // Every element is one thread's.
#pragma omp parallel for schedule(static)
  for (int i = 0; i < n; ++i) keyed[i] = {bounds.bounded(i) ? static_cast<std::uint32_t>(key(i)) : last, i};
  radix_sort(n, bits, keyed, other);
  while (n > 0 && keyed[n - 1].key == last) --n;
  order.resize(n);
  // Every element is one thread's.
#pragma omp parallel for schedule(static)
  for (int k = 0; k < n; ++k) order[k] = keyed[k].collider;
  return {keyed.data(), static_cast<std::size_t>(n)};
}

}  // namespace lockstep::rigid::openmp
