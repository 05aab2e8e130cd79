// Scalar functions with the names and the exact results of the lane functions in common/simd.h, so that a formula
// written once gives the same bits in a scalar loop and in lanes.
#pragma once

#include <bit>
#include <cmath>
#include <concepts>
#include <cstdint>

namespace lockstep {

// a < b ? a : b, which is what lanes compute: where either is NaN the answer is b. (std::min answers a.)
inline float min(float a, float b) { return a < b ? a : b; }
inline double min(double a, double b) { return a < b ? a : b; }
inline float max(float a, float b) { return a > b ? a : b; }
inline double max(double a, double b) { return a > b ? a : b; }

// A bool is a mask of one lane.
inline bool any(bool mask) { return mask; }
inline bool all(bool mask) { return mask; }
inline bool none(bool mask) { return !mask; }

// mask ? a : b; both are computed.
inline float select(bool mask, float a, float b) { return mask ? a : b; }
inline double select(bool mask, double a, double b) { return mask ? a : b; }
template <std::same_as<std::int32_t> I>  // of two integers; a float and the literal 0 are still floats
I select(bool mask, I a, I b) {
  return mask ? a : b;
}

// where(mask, x) = y assigns if mask is true, like its namesake of lanes.
template <class T>
struct WhereScalar {
  bool mask;
  T& variable;

  void operator=(T x) const {
    if (mask) variable = x;
  }
  void operator+=(T x) const { *this = variable + x; }
  void operator-=(T x) const { *this = variable - x; }
  void operator*=(T x) const { *this = variable * x; }
};
template <class T>
WhereScalar<T> where(bool mask, T& variable) {
  return {mask, variable};
}

inline float abs(float a) { return std::abs(a); }
inline double abs(double a) { return std::abs(a); }

inline float sqrt(float a) { return std::sqrt(a); }
inline double sqrt(double a) { return std::sqrt(a); }

// The same 32 bits.
inline std::int32_t bits_of(float a) { return std::bit_cast<std::int32_t>(a); }
inline float float_of_bits(std::int32_t a) { return std::bit_cast<float>(a); }

inline float to_float(std::int32_t a) { return static_cast<float>(a); }  // rounded to nearest

// Truncation towards zero; the caller has brought a into the range of int32.
inline std::int32_t to_int(float a) { return static_cast<std::int32_t>(a); }
inline std::int32_t to_int(double a) { return static_cast<std::int32_t>(a); }

}  // namespace lockstep
