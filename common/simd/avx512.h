// The back end for AVX-512 (x86-64-v4): one register a value, a mask register a mask. Contract: ../simd.h.

#ifndef LOCKSTEP_COMMON_SIMD_AVX512_H
#define LOCKSTEP_COMMON_SIMD_AVX512_H

// g++ 12 takes the undefined registers that its own intrinsics start from for mistakes of ours (GCC bug 105593).
#pragma GCC diagnostic push
#ifndef __clang__
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
#include <immintrin.h>
#pragma GCC diagnostic pop

#include "indexed.h"

namespace lockstep {

inline constexpr const char* isa_name = "avx512";
inline constexpr bool picks_from_vectors = true;

struct floatv {
  __m512 v;
  floatv() = default;
  LOCKSTEP_INLINE floatv(__m512 v) : v(v) {}
  LOCKSTEP_INLINE floatv(float x) : v(_mm512_set1_ps(x)) {}
};

struct intv {
  __m512i v;
  intv() = default;
  LOCKSTEP_INLINE intv(__m512i v) : v(v) {}
  LOCKSTEP_INLINE intv(std::int32_t x) : v(_mm512_set1_epi32(x)) {}
};

struct maskv {
  __mmask16 m;
};

LOCKSTEP_INLINE floatv load(const float* p) { return _mm512_loadu_ps(p); }
LOCKSTEP_INLINE intv load(const std::int32_t* p) { return _mm512_loadu_si512(p); }
LOCKSTEP_INLINE floatv load(const float* p, maskv mask) { return _mm512_maskz_loadu_ps(mask.m, p); }
LOCKSTEP_INLINE intv load(const std::int32_t* p, maskv mask) { return _mm512_maskz_loadu_epi32(mask.m, p); }
LOCKSTEP_INLINE void store(float* p, floatv v) { store_numbers(p, v.v); }
LOCKSTEP_INLINE void store(std::int32_t* p, intv v) { store_numbers(p, v.v); }
LOCKSTEP_INLINE void store(float* p, floatv v, maskv mask) { _mm512_mask_storeu_ps(p, mask.m, v.v); }
LOCKSTEP_INLINE void store(std::int32_t* p, intv v, maskv mask) { _mm512_mask_storeu_epi32(p, mask.m, v.v); }
LOCKSTEP_INLINE void stream(float* p, floatv v) { _mm512_stream_ps(p, v.v); }
LOCKSTEP_INLINE void finish_streams() { _mm_sfence(); }

struct Records {
  floatv field[8];
};

// Record l and record l + 8 share a register; three rounds of shuffles turn eight such rows into eight fields.
LOCKSTEP_INLINE Records load_records(const float* records, const std::int32_t* index) {
  __m512 row[8], pair[8], quad[8];
  for (int l = 0; l < 8; ++l) {
    const __m256 low = _mm256_load_ps(record_at<8>(records, index[l]));
    const __m256 high = _mm256_load_ps(record_at<8>(records, index[l + 8]));
    row[l] = _mm512_insertf32x8(_mm512_castps256_ps512(low), high, 1);
  }
  for (int l = 0; l < 8; l += 2) {
    pair[l] = _mm512_unpacklo_ps(row[l], row[l + 1]);
    pair[l + 1] = _mm512_unpackhi_ps(row[l], row[l + 1]);
  }
  for (int l = 0; l < 8; l += 4)
    for (int k = 0; k < 2; ++k) {
      const __m512d a = _mm512_castps_pd(pair[l + k]), b = _mm512_castps_pd(pair[l + k + 2]);
      quad[l + 2 * k] = _mm512_castpd_ps(_mm512_unpacklo_pd(a, b));
      quad[l + 2 * k + 1] = _mm512_castpd_ps(_mm512_unpackhi_pd(a, b));
    }
  const __m512i low = _mm512_setr_epi32(0, 1, 2, 3, 16, 17, 18, 19, 8, 9, 10, 11, 24, 25, 26, 27);
  const __m512i high = _mm512_setr_epi32(4, 5, 6, 7, 20, 21, 22, 23, 12, 13, 14, 15, 28, 29, 30, 31);
  Records r;
  for (int f = 0; f < 4; ++f) {
    r.field[f] = _mm512_permutex2var_ps(quad[f], low, quad[f + 4]);
    r.field[f + 4] = _mm512_permutex2var_ps(quad[f], high, quad[f + 4]);
  }
  return r;
}

// Rounds of shuffles within quarters make quarters of records; then the two quarters of each record are put side by
// side.
LOCKSTEP_INLINE void store_records(float* records, const std::int32_t* index, const Records& r, maskv mask) {
  __m512d quarter[8];  // [4 half + k]: that half of records k, k + 4, k + 8, k + 12
  for (int f = 0; f < 8; f += 4) {
    const __m512d low_a = _mm512_castps_pd(_mm512_unpacklo_ps(r.field[f].v, r.field[f + 1].v));
    const __m512d high_a = _mm512_castps_pd(_mm512_unpackhi_ps(r.field[f].v, r.field[f + 1].v));
    const __m512d low_b = _mm512_castps_pd(_mm512_unpacklo_ps(r.field[f + 2].v, r.field[f + 3].v));
    const __m512d high_b = _mm512_castps_pd(_mm512_unpackhi_ps(r.field[f + 2].v, r.field[f + 3].v));
    quarter[f] = _mm512_unpacklo_pd(low_a, low_b);
    quarter[f + 1] = _mm512_unpackhi_pd(low_a, low_b);
    quarter[f + 2] = _mm512_unpacklo_pd(high_a, high_b);
    quarter[f + 3] = _mm512_unpackhi_pd(high_a, high_b);
  }
  const __m512i first_two = _mm512_setr_epi64(0, 1, 8, 9, 2, 3, 10, 11),
                last_two = _mm512_setr_epi64(4, 5, 12, 13, 6, 7, 14, 15);
  const auto put = [&](int l, __m512d two) {
    const __m512 both = _mm512_castpd_ps(two);
    if (mask.m >> l & 1) _mm256_store_ps(record_at<8>(records, index[l]), _mm512_castps512_ps256(both));
    if (mask.m >> (l + 4) & 1) _mm256_store_ps(record_at<8>(records, index[l + 4]), _mm512_extractf32x8_ps(both, 1));
  };
  for (int k = 0; k < 4; ++k) {
    put(k, _mm512_permutex2var_pd(quarter[k], first_two, quarter[k + 4]));
    put(k + 8, _mm512_permutex2var_pd(quarter[k], last_two, quarter[k + 4]));
  }
}

struct recordv {
  __m256 v;
  recordv() = default;
  LOCKSTEP_INLINE recordv(__m256 v) : v(v) {}
  LOCKSTEP_INLINE recordv(float x) : v(_mm256_set1_ps(x)) {}
};
LOCKSTEP_INLINE recordv load_record(const float* p) { return _mm256_load_ps(p); }
LOCKSTEP_INLINE void store_record(float* p, recordv r) { _mm256_store_ps(p, r.v); }
LOCKSTEP_INLINE recordv repeat_pair(const float* p) {
  return _mm256_castpd_ps(_mm256_broadcast_sd(reinterpret_cast<const double*>(p)));
}
LOCKSTEP_INLINE recordv operator+(recordv a, recordv b) { return a.v + b.v; }
LOCKSTEP_INLINE recordv operator-(recordv a, recordv b) { return a.v - b.v; }
LOCKSTEP_INLINE recordv operator*(recordv a, recordv b) { return a.v * b.v; }
LOCKSTEP_INLINE void store_pairs(float* p, floatv a, floatv b) {
  const __m512i low = _mm512_setr_epi32(0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
  const __m512i high = _mm512_setr_epi32(8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31);
  _mm512_storeu_ps(p, _mm512_permutex2var_ps(a.v, low, b.v));
  _mm512_storeu_ps(p + 16, _mm512_permutex2var_ps(a.v, high, b.v));
}

struct Quads {
  floatv field[4];
};

// In every quarter of the registers, four rows of four floats become four columns.
LOCKSTEP_INLINE void transpose_quarters(__m512 (&row)[4]) {
  const __m512d low_a = _mm512_castps_pd(_mm512_unpacklo_ps(row[0], row[1])),
                high_a = _mm512_castps_pd(_mm512_unpackhi_ps(row[0], row[1]));
  const __m512d low_b = _mm512_castps_pd(_mm512_unpacklo_ps(row[2], row[3])),
                high_b = _mm512_castps_pd(_mm512_unpackhi_ps(row[2], row[3]));
  row[0] = _mm512_castpd_ps(_mm512_unpacklo_pd(low_a, low_b));
  row[1] = _mm512_castpd_ps(_mm512_unpackhi_pd(low_a, low_b));
  row[2] = _mm512_castpd_ps(_mm512_unpacklo_pd(high_a, high_b));
  row[3] = _mm512_castpd_ps(_mm512_unpackhi_pd(high_a, high_b));
}

// Row q holds records q, q + 4, q + 8 and q + 12, so that columns come out in the order of the lanes.
template <class Record>
LOCKSTEP_INLINE Quads quads_of(const Record& record) {
  __m512 row[4];
  for (int q = 0; q < 4; ++q) {
    const __m256 low = _mm256_insertf128_ps(_mm256_castps128_ps256(record(q)), record(q + 4), 1);
    const __m256 high = _mm256_insertf128_ps(_mm256_castps128_ps256(record(q + 8)), record(q + 12), 1);
    row[q] = _mm512_insertf32x8(_mm512_castps256_ps512(low), high, 1);
  }
  transpose_quarters(row);
  return {{row[0], row[1], row[2], row[3]}};
}

// Two indices are loaded at once and doubled together: no index is negative, so nothing is carried from one to the
// other. An address has a factor of 8 for free: record i begins at double 2 i.
LOCKSTEP_INLINE Quads load_quads(const float* records, const std::int32_t* index) {
  return quads_of([&](int l) {
    std::uint64_t two;
    std::memcpy(&two, index + l / 2 * 2, sizeof two);
    two += two;
    const std::uint64_t twice = l % 2 == 0 ? static_cast<std::uint32_t>(two) : two >> 32;
    return _mm_load_ps(reinterpret_cast<const float*>(reinterpret_cast<const double*>(records) + twice));
  });
}

LOCKSTEP_INLINE Quads gather_fours(const float* base, intv index) {
  alignas(64) std::int32_t first[lanes];
  store(first, index);
  return quads_of([&](int l) { return _mm_loadu_ps(base + first[l]); });
}

LOCKSTEP_INLINE void store_quads(float* records, const std::int32_t* index, Quads quads, maskv mask) {
  __m512 row[4] = {quads.field[0].v, quads.field[1].v, quads.field[2].v, quads.field[3].v};
  transpose_quarters(row);
  const auto put = [&](int l, __m128 record) {
    if (mask.m >> l & 1) _mm_store_ps(record_at<4>(records, index[l]), record);
  };
  for (int q = 0; q < 4; ++q) {
    put(q, _mm512_castps512_ps128(row[q]));
    put(q + 4, _mm512_extractf32x4_ps(row[q], 1));
    put(q + 8, _mm512_extractf32x4_ps(row[q], 2));
    put(q + 12, _mm512_extractf32x4_ps(row[q], 3));
  }
}

LOCKSTEP_INLINE floatv gather(const float* base, intv index, maskv mask) {
  return _mm512_mask_i32gather_ps(_mm512_setzero_ps(), mask.m, index.v, base, sizeof(float));
}
LOCKSTEP_INLINE intv gather(const std::int32_t* base, intv index, maskv mask) {
  return _mm512_mask_i32gather_epi32(_mm512_setzero_si512(), mask.m, index.v, base, sizeof(std::int32_t));
}
LOCKSTEP_INLINE floatv gather(const float* base, intv index) { return gather(base, index, maskv{0xffff}); }
LOCKSTEP_INLINE intv gather(const std::int32_t* base, intv index) { return gather(base, index, maskv{0xffff}); }

struct Halves {
  floatv first, second;
};

// Two gathers of eight pairs each, then the even and the odd floats of both.
LOCKSTEP_INLINE Halves gather_pairs(const float* base, intv index) {
  const auto pairs = [&](__m256i eight) {
    return _mm512_castpd_ps(_mm512_mask_i32gather_pd(_mm512_setzero_pd(), 0xff, eight, base, sizeof(float)));
  };
  const __m512 low = pairs(_mm512_castsi512_si256(index.v)), high = pairs(_mm512_extracti64x4_epi64(index.v, 1));
  const __m512i even = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
  const __m512i odd = _mm512_setr_epi32(1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31);
  return {_mm512_permutex2var_ps(low, even, high), _mm512_permutex2var_ps(low, odd, high)};
}

LOCKSTEP_INLINE floatv operator+(floatv a, floatv b) { return a.v + b.v; }
LOCKSTEP_INLINE floatv operator-(floatv a, floatv b) { return a.v - b.v; }
LOCKSTEP_INLINE floatv operator*(floatv a, floatv b) { return a.v * b.v; }
LOCKSTEP_INLINE floatv operator/(floatv a, floatv b) { return a.v / b.v; }
LOCKSTEP_INLINE floatv operator-(floatv a) { return -a.v; }
LOCKSTEP_INLINE floatv min(floatv a, floatv b) { return _mm512_min_ps(a.v, b.v); }
LOCKSTEP_INLINE floatv max(floatv a, floatv b) { return _mm512_max_ps(a.v, b.v); }
LOCKSTEP_INLINE floatv abs(floatv a) { return _mm512_abs_ps(a.v); }
LOCKSTEP_INLINE floatv sqrt(floatv a) { return _mm512_sqrt_ps(a.v); }
LOCKSTEP_INLINE floatv fma(floatv a, floatv b, floatv c) { return _mm512_fmadd_ps(a.v, b.v, c.v); }

LOCKSTEP_INLINE intv operator+(intv a, intv b) { return _mm512_add_epi32(a.v, b.v); }
LOCKSTEP_INLINE intv operator-(intv a, intv b) { return _mm512_sub_epi32(a.v, b.v); }
LOCKSTEP_INLINE intv operator*(intv a, intv b) { return _mm512_mullo_epi32(a.v, b.v); }
LOCKSTEP_INLINE intv operator&(intv a, intv b) { return _mm512_and_si512(a.v, b.v); }
LOCKSTEP_INLINE intv operator|(intv a, intv b) { return _mm512_or_si512(a.v, b.v); }
LOCKSTEP_INLINE intv operator^(intv a, intv b) { return _mm512_xor_si512(a.v, b.v); }
LOCKSTEP_INLINE intv operator<<(intv a, intv n) { return _mm512_sllv_epi32(a.v, n.v); }
LOCKSTEP_INLINE intv operator>>(intv a, intv n) { return _mm512_srav_epi32(a.v, n.v); }
LOCKSTEP_INLINE intv min(intv a, intv b) { return _mm512_min_epi32(a.v, b.v); }
LOCKSTEP_INLINE intv max(intv a, intv b) { return _mm512_max_epi32(a.v, b.v); }
LOCKSTEP_INLINE intv to_int(floatv a) { return _mm512_cvttps_epi32(a.v); }
LOCKSTEP_INLINE floatv to_float(intv a) { return _mm512_cvtepi32_ps(a.v); }
LOCKSTEP_INLINE intv bits_of(floatv a) { return _mm512_castps_si512(a.v); }
LOCKSTEP_INLINE floatv float_of_bits(intv a) { return _mm512_castsi512_ps(a.v); }

LOCKSTEP_INLINE maskv operator<(floatv a, floatv b) { return {_mm512_cmp_ps_mask(a.v, b.v, _CMP_LT_OQ)}; }
LOCKSTEP_INLINE maskv operator<=(floatv a, floatv b) { return {_mm512_cmp_ps_mask(a.v, b.v, _CMP_LE_OQ)}; }
LOCKSTEP_INLINE maskv operator==(floatv a, floatv b) { return {_mm512_cmp_ps_mask(a.v, b.v, _CMP_EQ_OQ)}; }
LOCKSTEP_INLINE maskv operator!=(floatv a, floatv b) { return {_mm512_cmp_ps_mask(a.v, b.v, _CMP_NEQ_UQ)}; }
LOCKSTEP_INLINE maskv operator<(intv a, intv b) { return {_mm512_cmplt_epi32_mask(a.v, b.v)}; }
LOCKSTEP_INLINE maskv operator<=(intv a, intv b) { return {_mm512_cmple_epi32_mask(a.v, b.v)}; }
LOCKSTEP_INLINE maskv operator==(intv a, intv b) { return {_mm512_cmpeq_epi32_mask(a.v, b.v)}; }
LOCKSTEP_INLINE maskv operator!=(intv a, intv b) { return {_mm512_cmpneq_epi32_mask(a.v, b.v)}; }

LOCKSTEP_INLINE maskv operator&(maskv a, maskv b) { return {static_cast<__mmask16>(a.m & b.m)}; }
LOCKSTEP_INLINE maskv operator|(maskv a, maskv b) { return {static_cast<__mmask16>(a.m | b.m)}; }
LOCKSTEP_INLINE maskv operator^(maskv a, maskv b) { return {static_cast<__mmask16>(a.m ^ b.m)}; }
LOCKSTEP_INLINE maskv operator~(maskv a) { return {static_cast<__mmask16>(~a.m)}; }
LOCKSTEP_INLINE std::uint32_t bits(maskv mask) { return mask.m; }
LOCKSTEP_INLINE maskv lanes_of(std::uint32_t bits) { return {static_cast<__mmask16>(bits)}; }
LOCKSTEP_INLINE intv lane_index() { return _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15); }
LOCKSTEP_INLINE floatv select(maskv mask, floatv a, floatv b) { return _mm512_mask_blend_ps(mask.m, b.v, a.v); }
LOCKSTEP_INLINE intv select(maskv mask, intv a, intv b) { return _mm512_mask_blend_epi32(mask.m, b.v, a.v); }

// To a register and then, if need be, to memory: the compressing store is microcode on Zen 4, 15 times slower.
LOCKSTEP_INLINE floatv compress(maskv mask, floatv v) { return _mm512_maskz_compress_ps(mask.m, v.v); }
LOCKSTEP_INLINE intv compress(maskv mask, intv v) { return _mm512_maskz_compress_epi32(mask.m, v.v); }

LOCKSTEP_INLINE floatv permute(floatv v, intv index) { return _mm512_permutexvar_ps(index.v, v.v); }

LOCKSTEP_INLINE floatv shift_up(floatv v, float first) {
  return _mm512_castsi512_ps(
      _mm512_alignr_epi32(_mm512_castps_si512(v.v), _mm512_castps_si512(_mm512_set1_ps(first)), 15));
}
LOCKSTEP_INLINE floatv shift_down(floatv v, float last) {
  return _mm512_castsi512_ps(
      _mm512_alignr_epi32(_mm512_castps_si512(_mm512_set1_ps(last)), _mm512_castps_si512(v.v), 1));
}

// Rounds of shuffles within quarters of a register, then of whole quarters.
LOCKSTEP_INLINE void transpose(floatv (&row)[lanes]) {
  __m512 pair[lanes], quad[lanes];
  for (int l = 0; l < lanes; l += 2) {
    pair[l] = _mm512_unpacklo_ps(row[l].v, row[l + 1].v);
    pair[l + 1] = _mm512_unpackhi_ps(row[l].v, row[l + 1].v);
  }
  for (int l = 0; l < lanes; l += 4)
    for (int k = 0; k < 2; ++k) {
      const __m512d a = _mm512_castps_pd(pair[l + k]), b = _mm512_castps_pd(pair[l + k + 2]);
      quad[l + 2 * k] = _mm512_castpd_ps(_mm512_unpacklo_pd(a, b));
      quad[l + 2 * k + 1] = _mm512_castpd_ps(_mm512_unpackhi_pd(a, b));
    }
  // Register l + k now holds columns k, k + 4, k + 8, k + 12 of rows l .. l + 3, a quarter each.
  for (int k = 0; k < 4; ++k) {
    const __m512 even_top = _mm512_shuffle_f32x4(quad[k], quad[k + 4], 0x88),
                 odd_top = _mm512_shuffle_f32x4(quad[k], quad[k + 4], 0xdd);
    const __m512 even_bottom = _mm512_shuffle_f32x4(quad[k + 8], quad[k + 12], 0x88);
    const __m512 odd_bottom = _mm512_shuffle_f32x4(quad[k + 8], quad[k + 12], 0xdd);
    row[k].v = _mm512_shuffle_f32x4(even_top, even_bottom, 0x88);
    row[k + 4].v = _mm512_shuffle_f32x4(odd_top, odd_bottom, 0x88);
    row[k + 8].v = _mm512_shuffle_f32x4(even_top, even_bottom, 0xdd);
    row[k + 12].v = _mm512_shuffle_f32x4(odd_top, odd_bottom, 0xdd);
  }
}

template <int G>
LOCKSTEP_INLINE Halves split(floatv a, floatv b) {
  if constexpr (G == 1) return {_mm512_shuffle_ps(a.v, b.v, 0x88), _mm512_shuffle_ps(a.v, b.v, 0xdd)};
  const __m512d x = _mm512_castps_pd(a.v), y = _mm512_castps_pd(b.v);
  return {_mm512_castpd_ps(_mm512_unpacklo_pd(x, y)), _mm512_castpd_ps(_mm512_unpackhi_pd(x, y))};
}

template <int G>
LOCKSTEP_INLINE void join(Halves halves, floatv& a, floatv& b) {
  if constexpr (G == 1) {
    a = _mm512_unpacklo_ps(halves.first.v, halves.second.v);
    b = _mm512_unpackhi_ps(halves.first.v, halves.second.v);
  } else {
    const __m512d x = _mm512_castps_pd(halves.first.v), y = _mm512_castps_pd(halves.second.v);
    a = _mm512_castpd_ps(_mm512_unpacklo_pd(x, y));
    b = _mm512_castpd_ps(_mm512_unpackhi_pd(x, y));
  }
}

LOCKSTEP_INLINE __m256 min(__m256 a, __m256 b) { return _mm256_min_ps(a, b); }
LOCKSTEP_INLINE __m128 min(__m128 a, __m128 b) { return _mm_min_ps(a, b); }
LOCKSTEP_INLINE __m256 max(__m256 a, __m256 b) { return _mm256_max_ps(a, b); }
LOCKSTEP_INLINE __m128 max(__m128 a, __m128 b) { return _mm_max_ps(a, b); }
template <class Combine>
LOCKSTEP_INLINE float reduce_lanes(floatv v, Combine combine) {
  const __m256 eight = combine(_mm512_castps512_ps256(v.v), _mm512_extractf32x8_ps(v.v, 1));
  const __m128 four = combine(_mm256_castps256_ps128(eight), _mm256_extractf128_ps(eight, 1));
  const __m128 two = combine(four, _mm_movehl_ps(four, four));
  return _mm_cvtss_f32(combine(two, _mm_movehdup_ps(two)));
}
LOCKSTEP_INLINE std::int32_t reduce_add(intv v) {
  const __m256i eight = _mm256_add_epi32(_mm512_castsi512_si256(v.v), _mm512_extracti64x4_epi64(v.v, 1));
  const __m128i four = _mm_add_epi32(_mm256_castsi256_si128(eight), _mm256_extracti128_si256(eight, 1));
  const __m128i two = _mm_hadd_epi32(four, four);
  return _mm_cvtsi128_si32(_mm_hadd_epi32(two, two));
}

}  // namespace lockstep

#endif
