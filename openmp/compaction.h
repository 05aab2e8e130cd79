// Moves the chosen ones of n elements together, in their order, by all threads.
//
// Threads first choose, a chunk at a time. Each chunk counts its own; one thread adds the counts of chunks up. Then an
// element knows where it goes: behind the chosen ones of the chunks before, and of those before it in its own chunk. So
// threads move elements at once, and the result does not depend on who did what.
//
//   Compaction keep(n);
//   #pragma omp parallel for
//   for (int chunk = 0; chunk < keep.chunks(); ++chunk)
//     keep.for_each_sixteen(chunk, [&](int i) { keep.choose(i, ...); });
//   resize(kept, keep.add_up());
//   #pragma omp parallel for
//   for (int chunk = 0; chunk < keep.chunks(); ++chunk)
//     keep.for_each_sixteen(chunk, [&](int i) { keep.move(i, {{from, to}}); });
//
// Source: Blelloch, Prefix Sums and Their Applications (1990).
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <memory>
#include <utility>

#include "common/simd.h"

namespace lockstep::openmp {

class Compaction {
 public:
  // Elements. Some thousand chunks of a million elements cost one thread a microsecond to add up.
  static constexpr int chunk_size = 1024;

  // Allocates, so it is made outside of parallel regions.
  explicit Compaction(int n)
      : n_(n),
        sixteens_(std::make_unique_for_overwrite<Sixteen[]>(n / lanes + 1)),
        before_(std::make_unique<std::int32_t[]>(chunks() + 1)) {}

  int chunks() const { return (n_ + chunk_size - 1) / chunk_size; }

  // Calls f(i) for the first of every sixteen elements of a chunk, in order; of the last there may be fewer.
  template <class F>
  void for_each_sixteen(int chunk, const F& f) const {
    for (int i = chunk * chunk_size; i < std::min(n_, (chunk + 1) * chunk_size); i += lanes) f(i);
  }

  // Chooses among elements i .. i + 15. One thread does a chunk's, in order; those beyond the end are not chosen.
  void choose(int i, maskv chosen) {
    const std::uint32_t which = bits(chosen & first_lanes(n_ - i));
    std::int32_t& in_chunk = before_[i / chunk_size];  // until they are added up
    sixteens_[i / lanes] = {in_chunk, static_cast<std::uint16_t>(which)};
    in_chunk += std::popcount(which);
  }

  // Once, when all have been chosen. Returns how many they are.
  int add_up() {
    if (n_ % lanes == 0) sixteens_[n_ / lanes] = {n_ % chunk_size == 0 ? 0 : before_[n_ / chunk_size], 0};
    std::int32_t sum = 0;
    for (int chunk = 0; chunk <= chunks(); ++chunk) sum += std::exchange(before_[chunk], sum);
    return sum;
  }

  // Which of i .. i + 15 are chosen, and how many of 0 .. i - 1, where i is a multiple of sixteen.
  std::uint32_t which(int i) const { return sixteens_[i / lanes].which; }
  int before(int i) const { return before_[i / chunk_size] + sixteens_[i / lanes].before; }

  // How many of 0 .. i - 1 are chosen, for any i from 0 to n.
  int before_any(int i) const {
    const std::uint32_t lesser = (1u << i % lanes) - 1;
    return before(i) + std::popcount(which(i) & lesser);
  }

  struct Column {
    const float* from;
    float* to;
  };

  // Moves the chosen ones of elements i .. i + 15 of each array.
  template <int count>
  LOCKSTEP_INLINE void move(int i, const Column (&columns)[count]) const {
    const int to = before(i);
    if (which(i) == 0xffff) {
      for (const Column& column : columns) store(column.to + to, load(column.from + i));
    } else {
      const maskv chosen = lanes_of(which(i)), filled = first_lanes(std::popcount(which(i)));
      for (const Column& column : columns) store(column.to + to, compress(chosen, load(column.from + i)), filled);
    }
  }

 private:
  struct Sixteen {
    std::int32_t before;  // chosen before them in their chunk
    std::uint16_t which;
  };

  int n_;
  std::unique_ptr<Sixteen[]> sixteens_;
  std::unique_ptr<std::int32_t[]> before_;  // [chunk]: chosen in the chunk, and then in all before it
};

}  // namespace lockstep::openmp
