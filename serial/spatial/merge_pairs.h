// Merges two lists of pairs.
#pragma once

#include <algorithm>
#include <iterator>

#include "common/spatial/pairs.h"

namespace lockstep::spatial::serial {

// Out: the pairs of two lists, each in order, in order.
inline void merge_pairs(const Pairs& a, const Pairs& b, Pairs& merged) {
  merged.clear();
  std::ranges::merge(a, b, std::back_inserter(merged));
}

}  // namespace lockstep::spatial::serial
