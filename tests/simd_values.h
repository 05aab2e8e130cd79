// Values for the tests of common/simd.h: lanes of special and of random numbers, and what lanes hold.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cfloat>
#include <climits>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

#include "common/simd.h"

namespace lockstep {

using Floats = std::array<float, lanes>;
using Ints = std::array<std::int32_t, lanes>;

// Test values: every special one meets every other sooner or later, and random bits reach all exponents.
inline constexpr float inf = std::numeric_limits<float>::infinity();
inline constexpr float nan = std::numeric_limits<float>::quiet_NaN();
inline constexpr float denormal = std::numeric_limits<float>::denorm_min();
inline constexpr float special_floats[] = {
    0,        -0.0f, denormal, -denormal, FLT_MIN / 2, FLT_MIN,        -FLT_MIN, 1e-20f,          0.5f,    1,
    -1,       -1.5f, 3,        0x1p23f,   0x1p31f,     0x1.fffffep30f, -0x1p31f, -0x1.000002p31f, 0x1p64f, FLT_MAX,
    -FLT_MAX, inf,   -inf,     nan,       -nan};
inline constexpr std::int32_t special_ints[] = {0,     1,        -1,        2,       31,      32,         65535,
                                                65536, 0x7fffff, 0x1000001, INT_MAX, INT_MIN, INT_MIN + 1};

struct Random {
  std::mt19937 engine{1};

  std::uint32_t bits() { return static_cast<std::uint32_t>(engine()); }
  int below(int n) { return static_cast<int>(bits() % static_cast<std::uint32_t>(n)); }
  operator float() {
    switch (below(3)) {
      case 0: return special_floats[below(std::size(special_floats))];
      case 1: return std::bit_cast<float>(bits());
      default: return std::uniform_real_distribution<float>(-10, 10)(engine);
    }
  }
  operator std::int32_t() {
    return below(2) ? special_ints[below(std::size(special_ints))] : static_cast<std::int32_t>(bits());
  }
  operator Floats() { return fill<Floats>(); }
  operator Ints() { return fill<Ints>(); }

  template <class Array>
  Array fill() {
    Array a;
    for (auto& x : a) x = *this;
    return a;
  }
  Ints ints_below(int n) {
    Ints a;
    for (auto& x : a) x = below(n);
    return a;
  }
};

inline floatv load(const Floats& a) { return lockstep::load(a.data()); }
inline intv load(const Ints& a) { return lockstep::load(a.data()); }

inline maskv mask_of(std::uint32_t b) { return (intv(static_cast<std::int32_t>(b)) >> lane_index() & 1) != 0; }
inline bool active(std::uint32_t mask, int l) { return mask >> l & 1; }

// Lane l of a result.
inline Floats values(floatv v) {
  Floats a;
  store(a.data(), v);
  return a;
}
inline Ints values(intv v) {
  Ints a;
  store(a.data(), v);
  return a;
}
inline std::array<bool, lanes> values(maskv m) {
  std::array<bool, lanes> a;
  for (int l = 0; l < lanes; ++l) a[l] = active(bits(m), l);
  return a;
}

// Same bits; where an operation computes rather than copies, any NaN will do for a NaN.
enum class Nan { computed, copied };
inline bool same(float a, float b, Nan nan) {
  return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b) ||
         (nan == Nan::computed && std::isnan(a) && std::isnan(b));
}
inline bool same(std::int32_t a, std::int32_t b, Nan) { return a == b; }
inline bool same(bool a, bool b, Nan) { return a == b; }

// expected(l) is the scalar result of lane l.
template <class V, class Expected>
testing::AssertionResult lanes_are(V v, Expected expected, Nan nan = Nan::copied) {
  const auto got = values(v);
  for (int l = 0; l < lanes; ++l)
    if (!same(got[l], expected(l), nan))
      return testing::AssertionFailure() << "lane " << l << ": " << got[l] << " instead of " << expected(l);
  return testing::AssertionSuccess();
}

inline constexpr int trials = 3000;

}  // namespace lockstep
