// Puts pairs in order, in sequence. In parallel: openmp/spatial/order_pairs.h.
#pragma once

#include <algorithm>

#include "common/counting_sort.h"
#include "common/spatial/pairs.h"

namespace lockstep::spatial {

// Orders pairs by a and then by b. Pairs are of elements 0 .. elements - 1.
//
// A counting sort by a; the few pairs that share an a are then sorted by b. (std::sort of a million pairs takes four
// times as long.)
inline void order_pairs(int elements, Pairs& pairs) {
  std::vector<std::int32_t> begin;  // [a]
  Pairs sorted(pairs.size());
  stable_counting_sort(
      elements,
      [&](const auto& visit) {
        for (const Pair& pair : pairs) visit(pair, pair.a);
      },
      [&](const Pair& pair, int place) { sorted[place] = pair; }, begin);
  for (int a = 0; a < elements; ++a) std::sort(sorted.begin() + begin[a], sorted.begin() + begin[a + 1]);
  pairs.swap(sorted);
}

}  // namespace lockstep::spatial
