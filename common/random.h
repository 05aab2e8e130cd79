// Random numbers without a state: four words are a function of a counter of four words and a key of two. So every
// thread and lane computes the numbers that it needs, in whatever order, and they are the same at every number of
// threads. The words of two counters or keys that differ, if only in a bit, have nothing to do with each other, as far
// as statistical tests can tell.
//
// The function is Philox4x32 with ten rounds: Random123's in serial/random.h, and in lanes in openmp/random.h.
//
// Source: Salmon, Moraes, Dror and Shaw, Parallel random numbers: as easy as 1, 2, 3, SC 2011.
#pragma once

#include <cstdint>

#include "common/math.h"

namespace lockstep {

// Index: std::int32_t or intv. All 32 bits are random.
template <class Index>
struct FourWords {
  Index word[4];
};

struct RandomKey {
  std::uint32_t word[2];
};

// From 0 to 1 - 2^-24, each multiple of 2^-24 as likely: the upper 24 bits of a word.
template <class Number, class Index>
inline Number unit(const Index& word) {
  return Number(to_float((word >> Index(8)) & Index(0xffffff))) * Number(0x1p-24f);
}

}  // namespace lockstep
