// Pairs, each once and in any order, put in the order of common/spatial/pairs.h. In parallel: openmp/spatial/order_pairs.h.
#pragma once

#include <algorithm>

#include "common/spatial/pairs.h"

namespace lockstep::spatial {

// A counting sort by a; the few pairs that share an a are then sorted by b. (std::sort of a million pairs takes four times as long.)
inline void order_pairs(int colliders, Pairs& pairs) {
  std::vector<std::int32_t> begin(colliders + 2,
                                  0);  // at first begin[a + 2] counts a; in the end a's pairs are begin[a] .. begin[a + 1] - 1
  for (const Pair& pair : pairs) ++begin[pair.a + 2];
  for (int a = 0; a < colliders; ++a) begin[a + 2] += begin[a + 1];
  Pairs sorted(pairs.size());
  for (const Pair& pair : pairs) sorted[begin[pair.a + 1]++] = pair;
  for (int a = 0; a < colliders; ++a) std::sort(sorted.begin() + begin[a], sorted.begin() + begin[a + 1]);
  pairs.swap(sorted);
}

}  // namespace lockstep::spatial
