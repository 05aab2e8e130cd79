// Random numbers without a state: four words are a function of a counter of four words and a key of two. So every thread
// and lane computes the numbers that it needs, in whatever order, and they are the same at every number of threads.
// Counters that differ in a single bit give words that are independent for all that statistical tests can tell.
//
// The function is Philox4x32 with ten rounds. Here it is Random123's; openmp/random.h has the same for lanes.
//
// Source: Salmon, Moraes, Dror and Shaw, Parallel random numbers: as easy as 1, 2, 3, SC 2011.
#pragma once

#include <Random123/philox.h>

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

inline FourWords<std::int32_t> philox(const FourWords<std::int32_t>& counter, const RandomKey& key) {
  const auto word = [&](int k) { return static_cast<std::uint32_t>(counter.word[k]); };
  const auto random = r123::Philox4x32()({{word(0), word(1), word(2), word(3)}}, {{key.word[0], key.word[1]}});
  const auto signed_word = [&](int k) { return static_cast<std::int32_t>(random[k]); };
  return {signed_word(0), signed_word(1), signed_word(2), signed_word(3)};
}

// From 0 to 1 - 2^-24, each multiple of 2^-24 as likely: the upper 24 bits of a word.
template <class Number, class Index>
inline Number unit(const Index& word) {
  return Number(to_float((word >> Index(8)) & Index(0xffffff))) * Number(0x1p-24f);
}

}  // namespace lockstep
