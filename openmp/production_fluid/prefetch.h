// Prefetching for passes of the pressure's solves over cells and their neighbours.
//
// Such a pass reads more arrays at once than the processor prefetches far enough ahead, so it waits for memory. With
// the farthest neighbour and the arrays beside it prefetched, a solve takes about .9 of the time.
#pragma once

#include "common/simd.h"

namespace lockstep::production_fluid::openmp {

// So many values of each array before their turn.
inline constexpr int ahead = 512;

// What stands `distance` values behind each place; it may lie outside of its array.
template <int distance, class... Values>
LOCKSTEP_INLINE void prefetch(const Values*... at) {
  (__builtin_prefetch(at + distance), ...);
}

}  // namespace lockstep::production_fluid::openmp
