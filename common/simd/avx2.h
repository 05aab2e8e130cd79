// The back end for AVX2 with FMA and BMI2 (x86-64-v3): two registers a value, lanes 0-7 in lo and 8-15 in hi. A
// mask is two registers as well, each lane all ones or all zeros. Contract: ../simd.h.
//
// One file, because every back end keeps the order of ../simd.h, so that back ends are read side by side.

#ifndef LOCKSTEP_COMMON_SIMD_AVX2_H
#define LOCKSTEP_COMMON_SIMD_AVX2_H

#include <immintrin.h>

#include "indexed.h"

namespace lockstep {

inline constexpr const char* isa_name = "avx2";
inline constexpr bool picks_from_vectors = false;

struct floatv {
  __m256 lo, hi;
  floatv() = default;
  LOCKSTEP_INLINE floatv(__m256 lo, __m256 hi) : lo(lo), hi(hi) {}
  LOCKSTEP_INLINE floatv(float x) : lo(_mm256_set1_ps(x)), hi(lo) {}
};

struct intv {
  __m256i lo, hi;
  intv() = default;
  LOCKSTEP_INLINE intv(__m256i lo, __m256i hi) : lo(lo), hi(hi) {}
  LOCKSTEP_INLINE intv(std::int32_t x) : lo(_mm256_set1_epi32(x)), hi(lo) {}
};

struct maskv {
  __m256i lo, hi;
};

// One register's type seen as another's.
LOCKSTEP_INLINE __m256 as_float(__m256i v) { return _mm256_castsi256_ps(v); }
LOCKSTEP_INLINE __m256i as_int(__m256 v) { return _mm256_castps_si256(v); }
LOCKSTEP_INLINE __m256i* as_int(std::int32_t* p) { return reinterpret_cast<__m256i*>(p); }
LOCKSTEP_INLINE const __m256i* as_int(const std::int32_t* p) { return reinterpret_cast<const __m256i*>(p); }

LOCKSTEP_INLINE floatv load(const float* p) { return {_mm256_loadu_ps(p), _mm256_loadu_ps(p + 8)}; }
LOCKSTEP_INLINE intv load(const std::int32_t* p) {
  return {_mm256_loadu_si256(as_int(p)), _mm256_loadu_si256(as_int(p + 8))};
}
LOCKSTEP_INLINE floatv load(const float* p, maskv mask) {
  return {_mm256_maskload_ps(p, mask.lo), _mm256_maskload_ps(p + 8, mask.hi)};
}
LOCKSTEP_INLINE intv load(const std::int32_t* p, maskv mask) {
  return {_mm256_maskload_epi32(p, mask.lo), _mm256_maskload_epi32(p + 8, mask.hi)};
}
LOCKSTEP_INLINE void store(float* p, floatv v) {
  store_numbers(p, v.lo);
  store_numbers(p + 8, v.hi);
}
LOCKSTEP_INLINE void store(std::int32_t* p, intv v) {
  store_numbers(p, v.lo);
  store_numbers(p + 8, v.hi);
}
LOCKSTEP_INLINE void store(float* p, floatv v, maskv mask) {
  _mm256_maskstore_ps(p, mask.lo, v.lo);
  _mm256_maskstore_ps(p + 8, mask.hi, v.hi);
}
LOCKSTEP_INLINE void store(std::int32_t* p, intv v, maskv mask) {
  _mm256_maskstore_epi32(p, mask.lo, v.lo);
  _mm256_maskstore_epi32(p + 8, mask.hi, v.hi);
}
LOCKSTEP_INLINE void stream(float* p, floatv v) {
  _mm256_stream_ps(p, v.lo);
  _mm256_stream_ps(p + 8, v.hi);
}
LOCKSTEP_INLINE void finish_streams() { _mm_sfence(); }

struct Records {
  floatv field[8];
};

// Eight rows of eight floats become eight columns.
LOCKSTEP_INLINE void transpose(__m256 (&row)[8]) {
  __m256 pair[8], quad[8];
  for (int l = 0; l < 8; l += 2) {
    pair[l] = _mm256_unpacklo_ps(row[l], row[l + 1]);
    pair[l + 1] = _mm256_unpackhi_ps(row[l], row[l + 1]);
  }
  for (int l = 0; l < 8; l += 4)
    for (int k = 0; k < 2; ++k) {
      quad[l + 2 * k] = _mm256_shuffle_ps(pair[l + k], pair[l + k + 2], 0x44);
      quad[l + 2 * k + 1] = _mm256_shuffle_ps(pair[l + k], pair[l + k + 2], 0xee);
    }
  for (int f = 0; f < 4; ++f) {
    row[f] = _mm256_permute2f128_ps(quad[f], quad[f + 4], 0x20);
    row[f + 4] = _mm256_permute2f128_ps(quad[f], quad[f + 4], 0x31);
  }
}

LOCKSTEP_INLINE Records load_records(const float* records, const std::int32_t* index) {
  __m256 low[8], high[8];
  for (int l = 0; l < 8; ++l) {
    low[l] = _mm256_load_ps(record_at<8>(records, index[l]));
    high[l] = _mm256_load_ps(record_at<8>(records, index[l + 8]));
  }
  transpose(low);
  transpose(high);
  Records r;
  for (int f = 0; f < 8; ++f) r.field[f] = {low[f], high[f]};
  return r;
}

LOCKSTEP_INLINE void store_records(float* records, const std::int32_t* index, const Records& r, maskv mask) {
  __m256 low[8], high[8];
  for (int f = 0; f < 8; ++f) low[f] = r.field[f].lo, high[f] = r.field[f].hi;
  transpose(low);
  transpose(high);
  const std::uint32_t set = bits(mask);
  for (int l = 0; l < 8; ++l) {
    if (set >> l & 1) _mm256_store_ps(record_at<8>(records, index[l]), low[l]);
    if (set >> (l + 8) & 1) _mm256_store_ps(record_at<8>(records, index[l + 8]), high[l]);
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
LOCKSTEP_INLINE void store_pairs(float* p, __m256 a, __m256 b) {
  const __m256 low = _mm256_unpacklo_ps(a, b), high = _mm256_unpackhi_ps(a, b);
  _mm256_storeu_ps(p, _mm256_permute2f128_ps(low, high, 0x20));
  _mm256_storeu_ps(p + 8, _mm256_permute2f128_ps(low, high, 0x31));
}
LOCKSTEP_INLINE void store_pairs(float* p, floatv a, floatv b) {
  store_pairs(p, a.lo, b.lo);
  store_pairs(p + 16, a.hi, b.hi);
}

struct Quads {
  floatv field[4];
};

// In both halves of the registers, four rows of four floats become four columns.
LOCKSTEP_INLINE void transpose_halves(__m256 (&row)[4]) {
  const __m256 low_a = _mm256_unpacklo_ps(row[0], row[1]), high_a = _mm256_unpackhi_ps(row[0], row[1]);
  const __m256 low_b = _mm256_unpacklo_ps(row[2], row[3]), high_b = _mm256_unpackhi_ps(row[2], row[3]);
  row[0] = _mm256_shuffle_ps(low_a, low_b, 0x44);
  row[1] = _mm256_shuffle_ps(low_a, low_b, 0xee);
  row[2] = _mm256_shuffle_ps(high_a, high_b, 0x44);
  row[3] = _mm256_shuffle_ps(high_a, high_b, 0xee);
}

// Row q holds records q and q + 4 of eight, so that columns come out in the order of the lanes.
template <class Record>
LOCKSTEP_INLINE Quads quads_of(const Record& record) {
  __m256 low[4], high[4];
  for (int q = 0; q < 4; ++q) {
    low[q] = _mm256_insertf128_ps(_mm256_castps128_ps256(record(q)), record(q + 4), 1);
    high[q] = _mm256_insertf128_ps(_mm256_castps128_ps256(record(q + 8)), record(q + 12), 1);
  }
  transpose_halves(low);
  transpose_halves(high);
  return {{{low[0], high[0]}, {low[1], high[1]}, {low[2], high[2]}, {low[3], high[3]}}};
}

LOCKSTEP_INLINE Quads load_quads(const float* records, const std::int32_t* index) {
  return quads_of([&](int l) { return _mm_load_ps(records + 4 * index_at(index, l)); });
}

LOCKSTEP_INLINE Quads gather_fours(const float* base, intv index) {
  alignas(64) std::int32_t first[lanes];
  store(first, index);
  return quads_of([&](int l) { return _mm_loadu_ps(base + index_at(first, l)); });
}

LOCKSTEP_INLINE std::uint32_t bits(maskv mask);

LOCKSTEP_INLINE void store_quads(float* records, const std::int32_t* index, Quads quads, maskv mask) {
  __m256 low[4], high[4];
  for (int f = 0; f < 4; ++f) low[f] = quads.field[f].lo, high[f] = quads.field[f].hi;
  transpose_halves(low);
  transpose_halves(high);
  const std::uint32_t active = bits(mask);
  const auto put = [&](int l, __m128 record) {
    if (active >> l & 1) _mm_store_ps(record_at<4>(records, index[l]), record);
  };
  for (int q = 0; q < 4; ++q) {
    put(q, _mm256_castps256_ps128(low[q]));
    put(q + 4, _mm256_extractf128_ps(low[q], 1));
    put(q + 8, _mm256_castps256_ps128(high[q]));
    put(q + 12, _mm256_extractf128_ps(high[q], 1));
  }
}

LOCKSTEP_INLINE floatv gather(const float* base, intv index, maskv mask) {
  const __m256 zero = _mm256_setzero_ps();
  return {_mm256_mask_i32gather_ps(zero, base, index.lo, as_float(mask.lo), sizeof(float)),
          _mm256_mask_i32gather_ps(zero, base, index.hi, as_float(mask.hi), sizeof(float))};
}
LOCKSTEP_INLINE intv gather(const std::int32_t* base, intv index, maskv mask) {
  const __m256i zero = _mm256_setzero_si256();
  return {_mm256_mask_i32gather_epi32(zero, base, index.lo, mask.lo, sizeof(std::int32_t)),
          _mm256_mask_i32gather_epi32(zero, base, index.hi, mask.hi, sizeof(std::int32_t))};
}

// By loads one by one, as gather_pairs: on a Zen 3 the gather instructions take longer (notes/simd.md).
LOCKSTEP_INLINE floatv gather(const float* base, intv index) {
  alignas(64) std::int32_t of_lanes[lanes];
  store(of_lanes, index);
  return {load_eight(base, of_lanes), load_eight(base, of_lanes + 8)};
}
LOCKSTEP_INLINE intv gather(const std::int32_t* base, intv index) {
  return {_mm256_i32gather_epi32(base, index.lo, sizeof(std::int32_t)),
          _mm256_i32gather_epi32(base, index.hi, sizeof(std::int32_t))};
}

struct Halves {
  floatv first, second;
};

LOCKSTEP_INLINE Halves gather_pairs(const float* base, intv index) {
  alignas(64) std::int32_t of_lanes[lanes];
  store(of_lanes, index);
  const auto two = [&](int l) {
    const auto pair = [&](int k) { return reinterpret_cast<const __m64*>(base + index_at(of_lanes, k)); };
    return _mm_loadh_pi(_mm_loadl_pi(_mm_setzero_ps(), pair(l)), pair(l + 1));
  };
  const auto four = [&](int l) { return _mm256_insertf128_ps(_mm256_castps128_ps256(two(l)), two(l + 4), 1); };
  const __m256 a = four(0), b = four(2), c = four(8), d = four(10);
  return {{_mm256_shuffle_ps(a, b, 0x88), _mm256_shuffle_ps(c, d, 0x88)},
          {_mm256_shuffle_ps(a, b, 0xdd), _mm256_shuffle_ps(c, d, 0xdd)}};
}

LOCKSTEP_INLINE floatv operator+(floatv a, floatv b) { return {a.lo + b.lo, a.hi + b.hi}; }
LOCKSTEP_INLINE floatv operator-(floatv a, floatv b) { return {a.lo - b.lo, a.hi - b.hi}; }
LOCKSTEP_INLINE floatv operator*(floatv a, floatv b) { return {a.lo * b.lo, a.hi * b.hi}; }
LOCKSTEP_INLINE floatv operator/(floatv a, floatv b) { return {a.lo / b.lo, a.hi / b.hi}; }
LOCKSTEP_INLINE floatv operator-(floatv a) { return {-a.lo, -a.hi}; }
LOCKSTEP_INLINE floatv min(floatv a, floatv b) { return {_mm256_min_ps(a.lo, b.lo), _mm256_min_ps(a.hi, b.hi)}; }
LOCKSTEP_INLINE floatv max(floatv a, floatv b) { return {_mm256_max_ps(a.lo, b.lo), _mm256_max_ps(a.hi, b.hi)}; }
LOCKSTEP_INLINE floatv abs(floatv a) {
  const __m256 sign = _mm256_set1_ps(-0.0f);
  return {_mm256_andnot_ps(sign, a.lo), _mm256_andnot_ps(sign, a.hi)};
}
LOCKSTEP_INLINE floatv sqrt(floatv a) { return {_mm256_sqrt_ps(a.lo), _mm256_sqrt_ps(a.hi)}; }
LOCKSTEP_INLINE floatv fma(floatv a, floatv b, floatv c) {
  return {_mm256_fmadd_ps(a.lo, b.lo, c.lo), _mm256_fmadd_ps(a.hi, b.hi, c.hi)};
}

LOCKSTEP_INLINE intv operator+(intv a, intv b) { return {_mm256_add_epi32(a.lo, b.lo), _mm256_add_epi32(a.hi, b.hi)}; }
LOCKSTEP_INLINE intv operator-(intv a, intv b) { return {_mm256_sub_epi32(a.lo, b.lo), _mm256_sub_epi32(a.hi, b.hi)}; }
LOCKSTEP_INLINE intv operator*(intv a, intv b) {
  return {_mm256_mullo_epi32(a.lo, b.lo), _mm256_mullo_epi32(a.hi, b.hi)};
}
LOCKSTEP_INLINE intv operator&(intv a, intv b) { return {_mm256_and_si256(a.lo, b.lo), _mm256_and_si256(a.hi, b.hi)}; }
LOCKSTEP_INLINE intv operator|(intv a, intv b) { return {_mm256_or_si256(a.lo, b.lo), _mm256_or_si256(a.hi, b.hi)}; }
LOCKSTEP_INLINE intv operator^(intv a, intv b) { return {_mm256_xor_si256(a.lo, b.lo), _mm256_xor_si256(a.hi, b.hi)}; }
LOCKSTEP_INLINE intv operator<<(intv a, intv n) {
  return {_mm256_sllv_epi32(a.lo, n.lo), _mm256_sllv_epi32(a.hi, n.hi)};
}
LOCKSTEP_INLINE intv operator>>(intv a, intv n) {
  return {_mm256_srav_epi32(a.lo, n.lo), _mm256_srav_epi32(a.hi, n.hi)};
}
LOCKSTEP_INLINE intv min(intv a, intv b) { return {_mm256_min_epi32(a.lo, b.lo), _mm256_min_epi32(a.hi, b.hi)}; }
LOCKSTEP_INLINE intv max(intv a, intv b) { return {_mm256_max_epi32(a.lo, b.lo), _mm256_max_epi32(a.hi, b.hi)}; }
LOCKSTEP_INLINE intv to_int(floatv a) { return {_mm256_cvttps_epi32(a.lo), _mm256_cvttps_epi32(a.hi)}; }
LOCKSTEP_INLINE floatv to_float(intv a) { return {_mm256_cvtepi32_ps(a.lo), _mm256_cvtepi32_ps(a.hi)}; }
LOCKSTEP_INLINE intv bits_of(floatv a) { return {as_int(a.lo), as_int(a.hi)}; }
LOCKSTEP_INLINE floatv float_of_bits(intv a) { return {as_float(a.lo), as_float(a.hi)}; }

template <int predicate>
LOCKSTEP_INLINE maskv compare_lanes(floatv a, floatv b) {
  return {as_int(_mm256_cmp_ps(a.lo, b.lo, predicate)), as_int(_mm256_cmp_ps(a.hi, b.hi, predicate))};
}
LOCKSTEP_INLINE maskv operator&(maskv a, maskv b) {
  return {_mm256_and_si256(a.lo, b.lo), _mm256_and_si256(a.hi, b.hi)};
}
LOCKSTEP_INLINE maskv operator|(maskv a, maskv b) { return {_mm256_or_si256(a.lo, b.lo), _mm256_or_si256(a.hi, b.hi)}; }
LOCKSTEP_INLINE maskv operator^(maskv a, maskv b) {
  return {_mm256_xor_si256(a.lo, b.lo), _mm256_xor_si256(a.hi, b.hi)};
}
LOCKSTEP_INLINE maskv operator~(maskv a) {
  const __m256i ones = _mm256_set1_epi32(-1);
  return a ^ maskv { ones, ones };
}
LOCKSTEP_INLINE maskv operator<(floatv a, floatv b) { return compare_lanes<_CMP_LT_OQ>(a, b); }
LOCKSTEP_INLINE maskv operator<=(floatv a, floatv b) { return compare_lanes<_CMP_LE_OQ>(a, b); }
LOCKSTEP_INLINE maskv operator==(floatv a, floatv b) { return compare_lanes<_CMP_EQ_OQ>(a, b); }
LOCKSTEP_INLINE maskv operator!=(floatv a, floatv b) { return compare_lanes<_CMP_NEQ_UQ>(a, b); }
LOCKSTEP_INLINE maskv operator<(intv a, intv b) {
  return {_mm256_cmpgt_epi32(b.lo, a.lo), _mm256_cmpgt_epi32(b.hi, a.hi)};
}
LOCKSTEP_INLINE maskv operator==(intv a, intv b) {
  return {_mm256_cmpeq_epi32(a.lo, b.lo), _mm256_cmpeq_epi32(a.hi, b.hi)};
}
LOCKSTEP_INLINE maskv operator<=(intv a, intv b) { return ~(b < a); }
LOCKSTEP_INLINE maskv operator!=(intv a, intv b) { return ~(a == b); }

LOCKSTEP_INLINE std::uint32_t bits(__m256i half) {
  return static_cast<std::uint32_t>(_mm256_movemask_ps(as_float(half)));
}
LOCKSTEP_INLINE std::uint32_t bits(maskv mask) { return bits(mask.lo) | bits(mask.hi) << 8; }
LOCKSTEP_INLINE maskv lanes_of(std::uint32_t bits) {
  const __m256i bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
  const auto half = [&](std::uint32_t eight) {
    return _mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32(static_cast<int>(eight)), bit), bit);
  };
  return {half(bits & 0xff), half(bits >> 8)};
}
LOCKSTEP_INLINE intv lane_index() {
  return {_mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7), _mm256_setr_epi32(8, 9, 10, 11, 12, 13, 14, 15)};
}
LOCKSTEP_INLINE floatv select(maskv mask, floatv a, floatv b) {
  return {_mm256_blendv_ps(b.lo, a.lo, as_float(mask.lo)), _mm256_blendv_ps(b.hi, a.hi, as_float(mask.hi))};
}
LOCKSTEP_INLINE intv select(maskv mask, intv a, intv b) {
  return {_mm256_blendv_epi8(b.lo, a.lo, mask.lo), _mm256_blendv_epi8(b.hi, a.hi, mask.hi)};
}

// AVX2 has no compress, but it permutes eight lanes by a vector of indices, and BMI2 makes that vector: with a byte
// for each lane, pext packs the numbers of the active ones. What they leave free is cleared. Joining the halves is
// left to memory: hi goes where the active lanes of lo end.
LOCKSTEP_INLINE __m256i compress_half(__m256i half, std::uint32_t active) {
  const std::uint64_t bytes = _pdep_u64(active, 0x0101010101010101) * 0xff;
  const std::uint64_t numbers = _pext_u64(0x0706050403020100, bytes);
  const __m256i index = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(static_cast<long long>(numbers)));
  const __m256i kept = _mm256_cmpgt_epi32(_mm256_set1_epi32(std::popcount(active)), lane_index().lo);
  return _mm256_and_si256(_mm256_permutevar8x32_epi32(half, index), kept);
}
LOCKSTEP_INLINE intv compress(maskv mask, intv v) {
  std::int32_t front[lanes];
  const std::uint32_t active = bits(mask.lo);
  store(front, intv(0));
  _mm256_storeu_si256(as_int(front), compress_half(v.lo, active));
  _mm256_storeu_si256(as_int(front + std::popcount(active)), compress_half(v.hi, bits(mask.hi)));
  return load(front);
}
LOCKSTEP_INLINE floatv compress(maskv mask, floatv v) {
  const intv front = compress(mask, intv(as_int(v.lo), as_int(v.hi)));
  return {as_float(front.lo), as_float(front.hi)};
}

// A permutation takes the low three bits of an index; the fourth, moved to the sign, says of which half.
LOCKSTEP_INLINE floatv permute(floatv v, intv index) {
  const auto from_both = [&](__m256i i) {
    return _mm256_blendv_ps(_mm256_permutevar8x32_ps(v.lo, i), _mm256_permutevar8x32_ps(v.hi, i),
                            _mm256_castsi256_ps(_mm256_slli_epi32(i, 28)));
  };
  return {from_both(index.lo), from_both(index.hi)};
}

LOCKSTEP_INLINE floatv shift_up(floatv v, float first) {
  const __m256i up = _mm256_setr_epi32(7, 0, 1, 2, 3, 4, 5, 6);
  const __m256 lo = _mm256_permutevar8x32_ps(v.lo, up), hi = _mm256_permutevar8x32_ps(v.hi, up);
  return {_mm256_blend_ps(lo, _mm256_set1_ps(first), 1), _mm256_blend_ps(hi, lo, 1)};
}
LOCKSTEP_INLINE floatv shift_down(floatv v, float last) {
  const __m256i down = _mm256_setr_epi32(1, 2, 3, 4, 5, 6, 7, 0);
  const __m256 lo = _mm256_permutevar8x32_ps(v.lo, down), hi = _mm256_permutevar8x32_ps(v.hi, down);
  return {_mm256_blend_ps(lo, hi, 0x80), _mm256_blend_ps(hi, _mm256_set1_ps(last), 0x80)};
}

// Four squares of eight; the two off the diagonal change places.
LOCKSTEP_INLINE void transpose(floatv (&row)[lanes]) {
  __m256 square[2][2][8];
  for (int l = 0; l < 8; ++l) {
    square[0][0][l] = row[l].lo, square[0][1][l] = row[l].hi;
    square[1][0][l] = row[l + 8].lo, square[1][1][l] = row[l + 8].hi;
  }
  for (auto& half : square)
    for (auto& eight : half) transpose(eight);
  for (int l = 0; l < 8; ++l) {
    row[l] = {square[0][0][l], square[1][0][l]};
    row[l + 8] = {square[0][1][l], square[1][1][l]};
  }
}

template <int G>
LOCKSTEP_INLINE Halves split(floatv a, floatv b) {
  if constexpr (G == 1)
    return {{_mm256_shuffle_ps(a.lo, b.lo, 0x88), _mm256_shuffle_ps(a.hi, b.hi, 0x88)},
            {_mm256_shuffle_ps(a.lo, b.lo, 0xdd), _mm256_shuffle_ps(a.hi, b.hi, 0xdd)}};
  return {{_mm256_shuffle_ps(a.lo, b.lo, 0x44), _mm256_shuffle_ps(a.hi, b.hi, 0x44)},
          {_mm256_shuffle_ps(a.lo, b.lo, 0xee), _mm256_shuffle_ps(a.hi, b.hi, 0xee)}};
}

template <int G>
LOCKSTEP_INLINE void join(Halves halves, floatv& a, floatv& b) {
  const auto [x, y] = halves;
  if constexpr (G == 1) {
    a = {_mm256_unpacklo_ps(x.lo, y.lo), _mm256_unpacklo_ps(x.hi, y.hi)};
    b = {_mm256_unpackhi_ps(x.lo, y.lo), _mm256_unpackhi_ps(x.hi, y.hi)};
  } else {
    a = {_mm256_shuffle_ps(x.lo, y.lo, 0x44), _mm256_shuffle_ps(x.hi, y.hi, 0x44)};
    b = {_mm256_shuffle_ps(x.lo, y.lo, 0xee), _mm256_shuffle_ps(x.hi, y.hi, 0xee)};
  }
}

LOCKSTEP_INLINE __m256 min(__m256 a, __m256 b) { return _mm256_min_ps(a, b); }
LOCKSTEP_INLINE __m128 min(__m128 a, __m128 b) { return _mm_min_ps(a, b); }
LOCKSTEP_INLINE __m256 max(__m256 a, __m256 b) { return _mm256_max_ps(a, b); }
LOCKSTEP_INLINE __m128 max(__m128 a, __m128 b) { return _mm_max_ps(a, b); }
template <class Combine>
LOCKSTEP_INLINE float reduce_lanes(floatv v, Combine combine) {
  const __m256 eight = combine(v.lo, v.hi);
  const __m128 four = combine(_mm256_castps256_ps128(eight), _mm256_extractf128_ps(eight, 1));
  const __m128 two = combine(four, _mm_movehl_ps(four, four));
  return _mm_cvtss_f32(combine(two, _mm_movehdup_ps(two)));
}
LOCKSTEP_INLINE std::int32_t reduce_add(intv v) {
  const __m256i eight = _mm256_add_epi32(v.lo, v.hi);
  const __m128i four = _mm_add_epi32(_mm256_castsi256_si128(eight), _mm256_extracti128_si256(eight, 1));
  const __m128i two = _mm_hadd_epi32(four, four);
  return _mm_cvtsi128_si32(_mm_hadd_epi32(two, two));
}

}  // namespace lockstep

#endif
