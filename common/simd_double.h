// Sixteen lanes of double beside the sixteen lanes of float in common/simd.h: for sums of products, and differences of
// numbers of nearly one size, that float would round; and for searches that need all of double's digits.
//
// The product of two floats is exact in double. A sum in a fixed tree has the same bits on every back end, and the same
// as scalar text that adds in that tree. Only what kernels need is here.
//
//   doublev to_double(floatv a)                    each lane widened: exact
//   floatv to_float(doublev a)                     each lane rounded once, to nearest
//   doublev operator+, -, *, / (doublev, doublev)  each rounds once, to nearest
//   doublev operator-(doublev a)                   flips the sign, also that of zero and NaN
//   doublev min, max(doublev a, doublev b)         a < b ? a : b, and a > b ? a : b
//   doublev abs, sqrt(doublev a)                   clears the sign; correctly rounded
//   doublev cbrt(doublev a)                        the library's, lane by lane: not for inner loops
//   maskv operator<, <=, >, >=, == (doublev, doublev)  false with a NaN
//   doublev select(maskv mask, doublev a, doublev b)   mask ? a : b
//   doublev load(const double* p)                  p[l]; any alignment
//   void store(double* p, doublev v)               p[l] = v; any alignment
//   Quarter                                        four doubles; Quarter(double x) sets them all to x
//   Quarter add_quarters(Quarter sum, doublev v)   sum[i] + v[i] + v[4 + i] + v[8 + i] + v[12 + i], from the left
//   double reduce_add(Quarter q)                   (q0 + q2) + (q1 + q3)
//   double reduce_add(doublev v)                   ((v0 + v8) + (v4 + v12)) + ..., the tree of reduce_add(floatv)
#pragma once

#include <cmath>

#include "common/simd.h"

namespace lockstep {

// The back ends differ in how many registers hold sixteen doubles; arithmetic on a register is the compiler's own.
#if defined(LOCKSTEP_ISA_AVX512)

struct doublev {
  __m512d low, high;
  doublev() = default;
  LOCKSTEP_INLINE doublev(__m512d low, __m512d high) : low(low), high(high) {}
  LOCKSTEP_INLINE doublev(double x) : low(_mm512_set1_pd(x)), high(low) {}
};
LOCKSTEP_INLINE doublev to_double(floatv a) {
  return {_mm512_cvtps_pd(_mm512_castps512_ps256(a.v)), _mm512_cvtps_pd(_mm512_extractf32x8_ps(a.v, 1))};
}
LOCKSTEP_INLINE doublev operator+(doublev a, doublev b) { return {a.low + b.low, a.high + b.high}; }
LOCKSTEP_INLINE doublev operator-(doublev a, doublev b) { return {a.low - b.low, a.high - b.high}; }
LOCKSTEP_INLINE doublev operator*(doublev a, doublev b) { return {a.low * b.low, a.high * b.high}; }
LOCKSTEP_INLINE doublev operator/(doublev a, doublev b) { return {a.low / b.low, a.high / b.high}; }
LOCKSTEP_INLINE doublev operator-(doublev a) { return {-a.low, -a.high}; }
LOCKSTEP_INLINE doublev min(doublev a, doublev b) {
  return {_mm512_min_pd(a.low, b.low), _mm512_min_pd(a.high, b.high)};
}
LOCKSTEP_INLINE doublev max(doublev a, doublev b) {
  return {_mm512_max_pd(a.low, b.low), _mm512_max_pd(a.high, b.high)};
}
LOCKSTEP_INLINE doublev abs(doublev a) { return {_mm512_abs_pd(a.low), _mm512_abs_pd(a.high)}; }
LOCKSTEP_INLINE doublev sqrt(doublev a) { return {_mm512_sqrt_pd(a.low), _mm512_sqrt_pd(a.high)}; }
template <int relation>
LOCKSTEP_INLINE maskv compare_lanes(doublev a, doublev b) {
  return {_mm512_kunpackb(_mm512_cmp_pd_mask(a.high, b.high, relation), _mm512_cmp_pd_mask(a.low, b.low, relation))};
}
LOCKSTEP_INLINE doublev select(maskv mask, doublev a, doublev b) {
  return {_mm512_mask_blend_pd(static_cast<__mmask8>(mask.m), b.low, a.low),
          _mm512_mask_blend_pd(static_cast<__mmask8>(mask.m >> 8), b.high, a.high)};
}
LOCKSTEP_INLINE floatv to_float(doublev a) {
  const __m512 low = _mm512_castps256_ps512(_mm512_cvtpd_ps(a.low));
  return floatv(_mm512_insertf32x8(low, _mm512_cvtpd_ps(a.high), 1));
}
LOCKSTEP_INLINE __m256d quarter_of(const doublev& v, int q) {
  const __m512d half = q < 2 ? v.low : v.high;
  return q % 2 == 0 ? _mm512_castpd512_pd256(half) : _mm512_extractf64x4_pd(half, 1);
}
LOCKSTEP_INLINE doublev load(const double* p) { return {_mm512_loadu_pd(p), _mm512_loadu_pd(p + 8)}; }
LOCKSTEP_INLINE void store(double* p, doublev v) {
  store_numbers(p, v.low);
  store_numbers(p + 8, v.high);
}

#elif defined(LOCKSTEP_ISA_AVX2)

struct doublev {
  __m256d quarter[4];
  doublev() = default;
  LOCKSTEP_INLINE doublev(__m256d a, __m256d b, __m256d c, __m256d d) : quarter{a, b, c, d} {}
  LOCKSTEP_INLINE doublev(double x) {
    for (__m256d& q : quarter) q = _mm256_set1_pd(x);
  }
};
LOCKSTEP_INLINE doublev to_double(floatv a) {
  return {_mm256_cvtps_pd(_mm256_castps256_ps128(a.lo)), _mm256_cvtps_pd(_mm256_extractf128_ps(a.lo, 1)),
          _mm256_cvtps_pd(_mm256_castps256_ps128(a.hi)), _mm256_cvtps_pd(_mm256_extractf128_ps(a.hi, 1))};
}
template <class F>
LOCKSTEP_INLINE doublev quarters(F f) {
  return {f(0), f(1), f(2), f(3)};
}
LOCKSTEP_INLINE doublev operator+(doublev a, doublev b) {
  return quarters([&](int q) { return a.quarter[q] + b.quarter[q]; });
}
LOCKSTEP_INLINE doublev operator-(doublev a, doublev b) {
  return quarters([&](int q) { return a.quarter[q] - b.quarter[q]; });
}
LOCKSTEP_INLINE doublev operator*(doublev a, doublev b) {
  return quarters([&](int q) { return a.quarter[q] * b.quarter[q]; });
}
LOCKSTEP_INLINE doublev operator/(doublev a, doublev b) {
  return quarters([&](int q) { return a.quarter[q] / b.quarter[q]; });
}
LOCKSTEP_INLINE doublev operator-(doublev a) {
  return quarters([&](int q) { return -a.quarter[q]; });
}
LOCKSTEP_INLINE doublev min(doublev a, doublev b) {
  return quarters([&](int q) { return _mm256_min_pd(a.quarter[q], b.quarter[q]); });
}
LOCKSTEP_INLINE doublev max(doublev a, doublev b) {
  return quarters([&](int q) { return _mm256_max_pd(a.quarter[q], b.quarter[q]); });
}
LOCKSTEP_INLINE doublev abs(doublev a) {
  return quarters([&](int q) { return _mm256_andnot_pd(_mm256_set1_pd(-0.), a.quarter[q]); });
}
LOCKSTEP_INLINE doublev sqrt(doublev a) {
  return quarters([&](int q) { return _mm256_sqrt_pd(a.quarter[q]); });
}
// Of two quarters, the even ones of sixteen numbers of 32 bits.
template <int relation>
LOCKSTEP_INLINE maskv compare_lanes(doublev a, doublev b) {
  const auto quarter = [&](int q) { return _mm256_castpd_ps(_mm256_cmp_pd(a.quarter[q], b.quarter[q], relation)); };
  const auto half = [&](int q) {
    return _mm256_permute4x64_epi64(as_int(_mm256_shuffle_ps(quarter(q), quarter(q + 1), 0x88)), 0xd8);
  };
  return {half(0), half(2)};
}
LOCKSTEP_INLINE doublev select(maskv mask, doublev a, doublev b) {
  return quarters([&](int q) {
    const __m256i half = q < 2 ? mask.lo : mask.hi;
    const __m128i four = q % 2 == 0 ? _mm256_castsi256_si128(half) : _mm256_extracti128_si256(half, 1);
    return _mm256_blendv_pd(b.quarter[q], a.quarter[q], _mm256_castsi256_pd(_mm256_cvtepi32_epi64(four)));
  });
}
LOCKSTEP_INLINE floatv to_float(doublev a) {
  return {_mm256_set_m128(_mm256_cvtpd_ps(a.quarter[1]), _mm256_cvtpd_ps(a.quarter[0])),
          _mm256_set_m128(_mm256_cvtpd_ps(a.quarter[3]), _mm256_cvtpd_ps(a.quarter[2]))};
}
LOCKSTEP_INLINE __m256d quarter_of(const doublev& v, int q) { return v.quarter[q]; }
LOCKSTEP_INLINE doublev load(const double* p) {
  return {_mm256_loadu_pd(p), _mm256_loadu_pd(p + 4), _mm256_loadu_pd(p + 8), _mm256_loadu_pd(p + 12)};
}
LOCKSTEP_INLINE void store(double* p, doublev v) {
  for (int q = 0; q < 4; ++q) store_numbers(p + 4 * q, v.quarter[q]);
}

#else

struct doublev {
  double lane[lanes];
  doublev() = default;
  LOCKSTEP_INLINE doublev(double x) {
    for (double& y : lane) y = x;
  }
};
LOCKSTEP_INLINE doublev to_double(floatv a) {
  return make_lanes<doublev>([&](int l) { return static_cast<double>(a.lane[l]); });
}
LOCKSTEP_INLINE doublev operator+(doublev a, doublev b) {
  return make_lanes<doublev>([&](int l) { return a.lane[l] + b.lane[l]; });
}
LOCKSTEP_INLINE doublev operator-(doublev a, doublev b) {
  return make_lanes<doublev>([&](int l) { return a.lane[l] - b.lane[l]; });
}
LOCKSTEP_INLINE doublev operator*(doublev a, doublev b) {
  return make_lanes<doublev>([&](int l) { return a.lane[l] * b.lane[l]; });
}
LOCKSTEP_INLINE doublev operator/(doublev a, doublev b) {
  return make_lanes<doublev>([&](int l) { return a.lane[l] / b.lane[l]; });
}
LOCKSTEP_INLINE doublev operator-(doublev a) {
  return make_lanes<doublev>([&](int l) { return -a.lane[l]; });
}
LOCKSTEP_INLINE doublev min(doublev a, doublev b) {
  return make_lanes<doublev>([&](int l) { return a.lane[l] < b.lane[l] ? a.lane[l] : b.lane[l]; });
}
LOCKSTEP_INLINE doublev max(doublev a, doublev b) {
  return make_lanes<doublev>([&](int l) { return a.lane[l] > b.lane[l] ? a.lane[l] : b.lane[l]; });
}
LOCKSTEP_INLINE doublev abs(doublev a) {
  return make_lanes<doublev>([&](int l) { return std::abs(a.lane[l]); });
}
LOCKSTEP_INLINE doublev sqrt(doublev a) {
  return make_lanes<doublev>([&](int l) { return std::sqrt(a.lane[l]); });
}
LOCKSTEP_INLINE maskv operator<(doublev a, doublev b) {
  return mask_lanes([&](int l) { return a.lane[l] < b.lane[l]; });
}
LOCKSTEP_INLINE maskv operator<=(doublev a, doublev b) {
  return mask_lanes([&](int l) { return a.lane[l] <= b.lane[l]; });
}
LOCKSTEP_INLINE maskv operator==(doublev a, doublev b) {
  return mask_lanes([&](int l) { return a.lane[l] == b.lane[l]; });
}
LOCKSTEP_INLINE doublev select(maskv mask, doublev a, doublev b) {
  return make_lanes<doublev>([&](int l) { return mask.lane[l] ? a.lane[l] : b.lane[l]; });
}
LOCKSTEP_INLINE floatv to_float(doublev a) {
  return make_lanes<floatv>([&](int l) { return static_cast<float>(a.lane[l]); });
}
LOCKSTEP_INLINE doublev load(const double* p) {
  return make_lanes<doublev>([&](int l) { return p[l]; });
}
LOCKSTEP_INLINE void store(double* p, doublev v) {
  for (int l = 0; l < lanes; ++l) p[l] = v.lane[l];
}

#endif

#if !defined(LOCKSTEP_ISA_PORTABLE)
LOCKSTEP_INLINE maskv operator<(doublev a, doublev b) { return compare_lanes<_CMP_LT_OQ>(a, b); }
LOCKSTEP_INLINE maskv operator<=(doublev a, doublev b) { return compare_lanes<_CMP_LE_OQ>(a, b); }
LOCKSTEP_INLINE maskv operator==(doublev a, doublev b) { return compare_lanes<_CMP_EQ_OQ>(a, b); }
#endif
LOCKSTEP_INLINE maskv operator>(doublev a, doublev b) { return b < a; }
LOCKSTEP_INLINE maskv operator>=(doublev a, doublev b) { return b <= a; }

LOCKSTEP_INLINE doublev cbrt(doublev v) {
  double lane[lanes];
  store(lane, v);
  for (double& x : lane) x = std::cbrt(x);
  return load(lane);
}

#if defined(LOCKSTEP_ISA_PORTABLE)
struct Quarter {
  double of[4];
  Quarter() = default;
  LOCKSTEP_INLINE Quarter(double x) : of{x, x, x, x} {}
};
LOCKSTEP_INLINE Quarter add_quarters(Quarter sum, const doublev& v) {
  for (int l = 0; l < lanes; ++l) sum.of[l % 4] += v.lane[l];
  return sum;
}
LOCKSTEP_INLINE double reduce_add(Quarter q) { return (q.of[0] + q.of[2]) + (q.of[1] + q.of[3]); }
#else
struct Quarter {
  __m256d v;
  Quarter() = default;
  LOCKSTEP_INLINE Quarter(double x) : v(_mm256_set1_pd(x)) {}
};
LOCKSTEP_INLINE Quarter add_quarters(Quarter sum, const doublev& v) {
  for (int q = 0; q < 4; ++q) sum.v = sum.v + quarter_of(v, q);
  return sum;
}
LOCKSTEP_INLINE double reduce_add(Quarter q) { return (q.v[0] + q.v[2]) + (q.v[1] + q.v[3]); }
#endif

// A sum is reduced once in a thousand elements, so that its tree may go through memory.
LOCKSTEP_INLINE double reduce_add(doublev v) {
  double lane[lanes];
  store(lane, v);
  for (int half = lanes / 2; half > 0; half /= 2)
    for (int l = 0; l < half; ++l) lane[l] += lane[l + half];
  return lane[0];
}

}  // namespace lockstep
