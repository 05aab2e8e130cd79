// Merges two lists of pairs, in parallel.
//
// A thread's share is a share of the result. It begins where as many pairs of both lists are behind it as stand before
// the share: a binary search along the merge path.
//
// Source: Odeh, Green, Mwassi, Shmueli and Birk, Merge Path: Parallel Merging Made Simple (2012).
#pragma once

#include <algorithm>
#include <cstddef>

#include "common/spatial/pairs.h"
#include "openmp/share.h"

namespace lockstep::spatial::openmp {

// How many of the first `n` pairs of the result come from a; the others come from b. Equal pairs: those of a first.
inline int taken_from_a(const Pairs& a, const Pairs& b, int n) {
  const int of_b = static_cast<int>(b.size());
  int low = std::max(0, n - of_b), high = std::min(n, static_cast<int>(a.size()));
  while (low < high) {
    const int middle = low + (high - low) / 2;
    if (b[n - middle - 1] < a[middle])
      high = middle;
    else
      low = middle + 1;
  }
  return low;
}

// Out: the pairs of two lists, each in order, in order.
inline void merge_pairs(const Pairs& a, const Pairs& b, Pairs& merged) {
  merged.resize(a.size() + b.size());
  // A thread writes its own share of the result.
#pragma omp parallel
  {
    const lockstep::openmp::Share mine = lockstep::openmp::my_share(static_cast<int>(merged.size()));
    const int first = taken_from_a(a, b, mine.begin), last = taken_from_a(a, b, mine.end);
    std::merge(a.begin() + first, a.begin() + last, b.begin() + (mine.begin - first), b.begin() + (mine.end - last),
               merged.begin() + mine.begin);
  }
}

}  // namespace lockstep::spatial::openmp
