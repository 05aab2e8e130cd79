// Loads of numbers at places of their own, which the back ends for AVX2 and AVX-512 share.

#ifndef LOCKSTEP_COMMON_SIMD_INDEXED_H
#define LOCKSTEP_COMMON_SIMD_INDEXED_H

#include <immintrin.h>

namespace lockstep {

// index[l], of an even number of indices. Two are loaded at once: one by one, to load and to extend them takes longer.
LOCKSTEP_INLINE std::int64_t index_at(const std::int32_t* index, int l) {
  std::int64_t two;
  std::memcpy(&two, index + l / 2 * 2, sizeof two);
  return l % 2 == 0 ? static_cast<std::int32_t>(two) : two >> 32;
}

// p[index[l]] for eight lanes.
LOCKSTEP_INLINE __m256 load_eight(const float* p, const std::int32_t* index) {
  const auto four = [&](int l) {
    const auto number = [&](int k) { return _mm_load_ss(p + index_at(index, l + k)); };
    const __m128 two = _mm_insert_ps(number(0), number(1), 0x10);
    return _mm_insert_ps(_mm_insert_ps(two, number(2), 0x20), number(3), 0x30);
  };
  return _mm256_insertf128_ps(_mm256_castps128_ps256(four(0)), four(4), 1);
}

}  // namespace lockstep

#endif
