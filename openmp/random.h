// Philox4x32 with ten rounds in lanes, sixteen counters at once: the words of serial/random.h.
//
// Source: Salmon, Moraes, Dror and Shaw, Parallel random numbers: as easy as 1, 2, 3, SC 2011.
#pragma once

#include <cstdint>

#include "common/random.h"
#include "common/simd.h"

namespace lockstep {

// The upper 32 bits of the product of two unsigned words: schoolbook, with digits of 16 bits. No sum overflows.
LOCKSTEP_INLINE intv upper_product(const intv& a, std::uint32_t b) {
  const intv digit = 0xffff;
  const auto upper = [&](const intv& word) { return (word >> intv(16)) & digit; };
  const intv low_a = a & digit, high_a = upper(a);
  const intv low_b = static_cast<std::int32_t>(b & 0xffff), high_b = static_cast<std::int32_t>(b >> 16);
  const intv first = high_a * low_b + upper(low_a * low_b);
  const intv second = low_a * high_b + (first & digit);
  return high_a * high_b + upper(first) + upper(second);
}

LOCKSTEP_INLINE FourWords<intv> philox(FourWords<intv> words, RandomKey key) {
  constexpr std::uint32_t factor[] = {0xd2511f53, 0xcd9e8d57}, step[] = {0x9e3779b9, 0xbb67ae85};
  const auto wide = [](std::uint32_t word) { return intv(static_cast<std::int32_t>(word)); };
  for (int round = 0; round < 10; ++round) {
    const auto& [a, b, c, d] = words.word;
    words = {upper_product(c, factor[1]) ^ b ^ wide(key.word[0]), c * wide(factor[1]),
             upper_product(a, factor[0]) ^ d ^ wide(key.word[1]), a * wide(factor[0])};
    key.word[0] += step[0], key.word[1] += step[1];
  }
  return words;
}

}  // namespace lockstep
