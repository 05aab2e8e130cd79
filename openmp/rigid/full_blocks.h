// Keeps vectors full where lanes need different numbers of iterations: when few lanes of a block are unfinished, the
// block ends, and the unfinished elements of a chunk are packed into full blocks again. It has no serial twin: there,
// no pair waits for another.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "common/rigid/narrow_phase.h"
#include "common/simd.h"

namespace lockstep::rigid::openmp {

inline constexpr int chunk_size = 512;  // at most
// From 2 to 5 it makes no difference. At 0, where nothing is packed again, hulls take 4 % longer and mixed shapes 14 %;
// at 8, 7 % longer, because setting up more blocks costs more than the iterations that are saved.
inline constexpr int few_lanes = 3;

// Elements 0 .. n - 1 <= chunk_size, in the order of key(k) < 256, in blocks of sixteen, again and again until none is
// left. block(which, enough) works on those elements until no more than `enough` are unfinished, puts these to the
// front of `which`, and returns how many they are.
template <class Key, class Block>
void in_full_blocks(int n, const Key& key_of, const Block& block) {
  // A counting sort.
  std::int32_t which[chunk_size];
  std::uint8_t key[chunk_size];
  int begin[257] = {};
  for (int k = 0; k < n; ++k) {
    key[k] = static_cast<std::uint8_t>(key_of(k));
    ++begin[key[k] + 1];
  }
  for (int f = 0; f < 256; ++f) begin[f + 1] += begin[f];
  for (int k = 0; k < n; ++k) which[begin[key[k]]++] = k;

  for (int left = n; left > 0;) {
    const int enough = left > lanes ? few_lanes : 0;
    int kept = 0;
    for (int k = 0; k < left; k += lanes) {
      const int unfinished = block(std::span(which + k, std::min(lanes, left - k)), enough);
      for (int l = 0; l < unfinished; ++l) which[kept++] = which[k + l];
    }
    left = kept;
  }
}

// How large two hulls are together, < 256: how many fours of vertices each has.
inline int size_key(const Placed<float>& placed, const Pair& pair) {
  const auto fours = [&](int collider) { return (placed.hulls.vertices(placed.colliders.hull[collider]) - 1) / 4; };
  return 16 * fours(pair.a) + fours(pair.b);
}

}  // namespace lockstep::rigid::openmp
