// Memory and records beside those of common/simd.h: numbers at places of their own, sixteen quads one after another,
// and comparison of single records.
//
//   floatv load_each(const float* p, const std::int32_t* index)
//     p[index[l]], by loads one by one: on a Zen 4 a gather takes longer
//   intv load_wide(const std::uint16_t* p)              p[l]
//   floatv choose(floatv a, floatv b, intv k)           lane k % 16 of a, or where k & 16 is set, of b
//   Quads load_sixteen_quads(const float* p)            field[f] lane l = p[4 l + f]; any alignment
//   void store_sixteen_quads(float* p, const Quads& q)  and back; any alignment
//   recordv min(recordv a, recordv b)                   a < b ? a : b, field by field
//   recordv max(recordv a, recordv b)                   a > b ? a : b
//   std::uint32_t less(recordv a, recordv b)            bit f: whether field f of a is less than that of b
#pragma once

#include "common/simd.h"

namespace lockstep {

#if !defined(LOCKSTEP_ISA_PORTABLE)
LOCKSTEP_INLINE recordv min(recordv a, recordv b) { return _mm256_min_ps(a.v, b.v); }
LOCKSTEP_INLINE recordv max(recordv a, recordv b) { return _mm256_max_ps(a.v, b.v); }
#endif

#if defined(LOCKSTEP_ISA_AVX512)

LOCKSTEP_INLINE floatv load_each(const float* p, const std::int32_t* index) {
  const __m512 low = _mm512_castps256_ps512(load_eight(p, index));
  return _mm512_insertf32x8(low, load_eight(p, index + 8), 1);
}

LOCKSTEP_INLINE intv load_wide(const std::uint16_t* p) {
  return _mm512_cvtepu16_epi32(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(p)));
}
LOCKSTEP_INLINE floatv choose(floatv a, floatv b, intv k) { return _mm512_permutex2var_ps(a.v, k.v, b.v); }

// Two vectors give two fields of eight records; then halves are put together.
LOCKSTEP_INLINE Quads load_sixteen_quads(const float* p) {
  const __m512i first_two = _mm512_setr_epi32(0, 4, 8, 12, 16, 20, 24, 28, 1, 5, 9, 13, 17, 21, 25, 29);
  const __m512i last_two = _mm512_setr_epi32(2, 6, 10, 14, 18, 22, 26, 30, 3, 7, 11, 15, 19, 23, 27, 31);
  const __m512 a = load(p).v, b = load(p + lanes).v, c = load(p + 2 * lanes).v, d = load(p + 3 * lanes).v;
  const __m512 xy_low = _mm512_permutex2var_ps(a, first_two, b), xy_high = _mm512_permutex2var_ps(c, first_two, d);
  const __m512 zw_low = _mm512_permutex2var_ps(a, last_two, b), zw_high = _mm512_permutex2var_ps(c, last_two, d);
  return {{_mm512_shuffle_f32x4(xy_low, xy_high, 0x44), _mm512_shuffle_f32x4(xy_low, xy_high, 0xee),
           _mm512_shuffle_f32x4(zw_low, zw_high, 0x44), _mm512_shuffle_f32x4(zw_low, zw_high, 0xee)}};
}

LOCKSTEP_INLINE void store_sixteen_quads(float* p, const Quads& quads) {
  const __m512i low = _mm512_setr_epi32(0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
  const __m512i high = _mm512_setr_epi32(8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31);
  const auto pairs = [&](int f, __m512i half) {
    return _mm512_castps_pd(_mm512_permutex2var_ps(quads.field[f].v, half, quads.field[f + 1].v));
  };
  const __m512i first_four = _mm512_setr_epi64(0, 8, 1, 9, 2, 10, 3, 11);
  const __m512i last_four = _mm512_setr_epi64(4, 12, 5, 13, 6, 14, 7, 15);
  const auto put = [&](int half, __m512d xy, __m512d zw) {
    store(p + 32 * half, floatv(_mm512_castpd_ps(_mm512_permutex2var_pd(xy, first_four, zw))));
    store(p + 32 * half + lanes, floatv(_mm512_castpd_ps(_mm512_permutex2var_pd(xy, last_four, zw))));
  };
  put(0, pairs(0, low), pairs(2, low)), put(1, pairs(0, high), pairs(2, high));
}

LOCKSTEP_INLINE std::uint32_t less(recordv a, recordv b) { return _mm256_cmp_ps_mask(a.v, b.v, _CMP_LT_OQ); }

#elif defined(LOCKSTEP_ISA_AVX2)

LOCKSTEP_INLINE floatv load_each(const float* p, const std::int32_t* index) {
  return {load_eight(p, index), load_eight(p, index + 8)};
}
LOCKSTEP_INLINE intv load_wide(const std::uint16_t* p) {
  const auto* const eight = reinterpret_cast<const __m128i*>(p);
  return {_mm256_cvtepu16_epi32(_mm_loadu_si128(eight)), _mm256_cvtepu16_epi32(_mm_loadu_si128(eight + 1))};
}
LOCKSTEP_INLINE Quads load_sixteen_quads(const float* p) {
  return quads_of([&](int l) { return _mm_loadu_ps(p + 4 * l); });
}
// After the transposition row q holds records q and q + 4 of eight.
LOCKSTEP_INLINE void store_sixteen_quads(float* p, const Quads& quads) {
  const auto store_eight = [&](float* to, __m256(&row)[4]) {
    transpose_halves(row);
    for (int q = 0; q < 4; q += 2) {
      store_numbers(to + 4 * q, _mm256_permute2f128_ps(row[q], row[q + 1], 0x20));
      store_numbers(to + 4 * q + 16, _mm256_permute2f128_ps(row[q], row[q + 1], 0x31));
    }
  };
  __m256 low[4], high[4];
  for (int f = 0; f < 4; ++f) low[f] = quads.field[f].lo, high[f] = quads.field[f].hi;
  store_eight(p, low), store_eight(p + 32, high);
}
LOCKSTEP_INLINE std::uint32_t less(recordv a, recordv b) {
  return static_cast<std::uint32_t>(_mm256_movemask_ps(_mm256_cmp_ps(a.v, b.v, _CMP_LT_OQ)));
}

#else

LOCKSTEP_INLINE floatv load_each(const float* p, const std::int32_t* index) {
  float of_lanes[lanes];
  for (int l = 0; l < lanes; ++l) of_lanes[l] = p[index[l]];
  return load(of_lanes);
}
LOCKSTEP_INLINE intv load_wide(const std::uint16_t* p) {
  std::int32_t of_lanes[lanes];
  for (int l = 0; l < lanes; ++l) of_lanes[l] = p[l];
  return load(of_lanes);
}
LOCKSTEP_INLINE Quads load_sixteen_quads(const float* p) {
  Quads quads;
  for (int f = 0; f < 4; ++f) {
    float field[lanes];
    for (int l = 0; l < lanes; ++l) field[l] = p[4 * l + f];
    quads.field[f] = load(field);
  }
  return quads;
}
LOCKSTEP_INLINE void store_sixteen_quads(float* p, const Quads& quads) {
  for (int f = 0; f < 4; ++f) {
    float field[lanes];
    store(field, quads.field[f]);
    for (int l = 0; l < lanes; ++l) p[4 * l + f] = field[l];
  }
}

LOCKSTEP_INLINE recordv min(recordv a, recordv b) {
  return make_record([&](int f) { return a.field[f] < b.field[f] ? a.field[f] : b.field[f]; });
}
LOCKSTEP_INLINE recordv max(recordv a, recordv b) {
  return make_record([&](int f) { return a.field[f] > b.field[f] ? a.field[f] : b.field[f]; });
}
LOCKSTEP_INLINE std::uint32_t less(recordv a, recordv b) {
  std::uint32_t bits = 0;
  for (int f = 0; f < 8; ++f) bits |= std::uint32_t(a.field[f] < b.field[f]) << f;
  return bits;
}

#endif

#if !defined(LOCKSTEP_ISA_AVX512)
LOCKSTEP_INLINE floatv choose(floatv a, floatv b, intv k) {
  float of_both[2 * lanes], of_lanes[lanes];
  std::int32_t at[lanes];
  store(of_both, a), store(of_both + lanes, b), store(at, k);
  for (int l = 0; l < lanes; ++l) of_lanes[l] = of_both[at[l] & (2 * lanes - 1)];
  return load(of_lanes);
}
#endif

}  // namespace lockstep
