// common/transcendental.h against the double library, whose error is 2^-29 of what is measured here. What it asserts:
//
// - log, exp and cbrt stay within the bounds that the header derives: every 1021st float of all 2^32, and all floats of
// some binades
// - sixteen lanes give the bits that sixteen numbers give, on the back end it is built for
// - what they give of zeros, infinities, NaNs, negative numbers and denormals

#include "common/transcendental.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstdio>
#include <limits>

#include "common/simd.h"

namespace lockstep {
namespace {

constexpr float inf = std::numeric_limits<float>::infinity();
constexpr float nan = std::numeric_limits<float>::quiet_NaN();

// The three, for a number, lanes and the truth.
struct Log {
  template <class V>
  V operator()(V x) const {
    return log(x);
  }
  double operator()(double x) const { return std::log(x); }
};
struct Exp {
  template <class V>
  V operator()(V x) const {
    return exp(x);
  }
  double operator()(double x) const { return std::exp(x); }
};
struct Cbrt {
  template <class V>
  V operator()(V x) const {
    return cbrt(x);
  }
  double operator()(double x) const { return std::cbrt(x); }
};

// How far a float is from the exact value, in ulp of that value: of the float's spacing where it lies. Infinity counts
// as the float that would come after the largest.
double ulps(float got, double exact) {
  const auto number = [](double x) { return std::isinf(x) ? std::copysign(0x1p128, x) : x; };
  if (std::isnan(exact) || std::isnan(got)) return std::isnan(exact) && std::isnan(got) ? 0 : 1e9;
  if (number(got) == number(exact)) return 0;
  if (std::isinf(got) && std::abs(exact) > 0x1p128 && (got > 0) == (exact > 0)) return 0;
  const auto biased = static_cast<int>(std::bit_cast<std::uint64_t>(exact) >> 52 & 0x7ff);
  const int exponent = std::clamp(biased - 1023, -126, 127);
  return std::abs(number(got) - exact) * std::bit_cast<double>(std::uint64_t(1023 + 23 - exponent) << 52);
}

struct Worst {
  double ulps = 0;
  float at = 0;
};

// Bit patterns first, first + step, ... up to last, in lanes and one by one.
template <class F>
void sweep(std::int64_t first, std::int64_t last, std::int64_t step, Worst& worst) {
  for (std::int64_t begin = first; begin <= last; begin += lanes * step) {
    float x[lanes], in_lanes[lanes];
    for (int l = 0; l < lanes; ++l)
      x[l] = std::bit_cast<float>(static_cast<std::uint32_t>(std::min(begin + l * step, last)));
    store(in_lanes, F()(load(x)));
    for (int l = 0; l < lanes; ++l) {
      const float got = F()(x[l]);
      const bool same = std::bit_cast<std::uint32_t>(got) == std::bit_cast<std::uint32_t>(in_lanes[l]);
      if (!same && !(std::isnan(got) && std::isnan(in_lanes[l])))
        FAIL() << "of " << x[l] << ": " << got << ", and " << in_lanes[l] << " in lanes";
      const double error = ulps(got, F()(double{x[l]}));
      if (error > worst.ulps) worst = {error, x[l]};
    }
  }
}

// All bit patterns from one float to another of the same sign.
template <class F>
void sweep_all(float from, float to, Worst& worst) {
  sweep<F>(std::bit_cast<std::uint32_t>(from), std::bit_cast<std::uint32_t>(to), 1, worst);
}

void expect_within(const char* name, const Worst& worst, double bound) {
  std::printf("%s: at most %.4f ulp, of %a\n", name, worst.ulps, worst.at);
  EXPECT_LE(worst.ulps, bound) << name << " of " << worst.at;
}

constexpr std::int64_t last_pattern = 0xffffffff, step = 1021;

TEST(Transcendental, Logarithm) {
  Worst worst;
  sweep<Log>(0, last_pattern, step, worst);
  sweep_all<Log>(.5f, 2, worst);        // around its zero, and where the exponent changes
  sweep_all<Log>(0, 0x1p-140f, worst);  // the smallest denormals
  expect_within("log", worst, .88);
}

TEST(Transcendental, Exponential) {
  Worst worst;
  sweep<Exp>(0, std::bit_cast<std::uint32_t>(inf), step, worst);
  sweep<Exp>(std::bit_cast<std::uint32_t>(-0.f), std::bit_cast<std::uint32_t>(-87.f), step, worst);
  sweep_all<Exp>(.25f, 1, worst);  // where n goes from 0 to 1
  sweep_all<Exp>(-.25f, -1, worst);
  sweep_all<Exp>(64, 89, worst);    // up to infinity
  sweep_all<Exp>(-64, -87, worst);  // down to the least normal number
  expect_within("exp", worst, .84);

  Worst of_denormals;
  sweep<Exp>(std::bit_cast<std::uint32_t>(-105.f), last_pattern, step, of_denormals);  // far below, and NaNs
  sweep_all<Exp>(-87.4f, -105, of_denormals);
  expect_within("exp, denormal", of_denormals, .92);
}

TEST(Transcendental, CubeRoot) {
  Worst worst;
  sweep<Cbrt>(0, last_pattern, step, worst);
  sweep_all<Cbrt>(1, 8, worst);
  sweep_all<Cbrt>(0, 0x1p-140f, worst);
  expect_within("cbrt", worst, .6);
}

TEST(Transcendental, CubesHaveExactRoots) {
  for (int i = 0; i <= 256; ++i) {  // i^3 is a float
    const float x = static_cast<float>(i);
    EXPECT_EQ(cbrt(x * x * x), x);
    EXPECT_EQ(cbrt(-x * x * x * 0x1p-60f), -x * 0x1p-20f);
  }
}

TEST(Transcendental, OfSpecialNumbers) {
  EXPECT_EQ(log(0.f), -inf);
  EXPECT_EQ(log(-0.f), -inf);
  EXPECT_EQ(log(1.f), 0);
  EXPECT_FALSE(std::signbit(log(1.f)));
  EXPECT_EQ(log(inf), inf);
  for (const float x : {-0x1p-149f, -1.f, -inf, nan, -nan}) EXPECT_TRUE(std::isnan(log(x))) << x;

  EXPECT_EQ(exp(0.f), 1);
  EXPECT_EQ(exp(-0.f), 1);
  EXPECT_EQ(exp(inf), inf);
  EXPECT_EQ(exp(1e30f), inf);
  EXPECT_EQ(exp(-inf), 0);
  EXPECT_EQ(exp(-1e30f), 0);
  EXPECT_EQ(exp(0x1p-149f), 1);
  EXPECT_TRUE(std::isnan(exp(nan)));
  EXPECT_TRUE(std::isnan(exp(-nan)));

  EXPECT_EQ(cbrt(0.f), 0);
  EXPECT_FALSE(std::signbit(cbrt(0.f)));
  EXPECT_TRUE(std::signbit(cbrt(-0.f)));
  EXPECT_EQ(cbrt(inf), inf);
  EXPECT_EQ(cbrt(-inf), -inf);
  EXPECT_EQ(cbrt(0x1p-147f), 0x1p-49f);
  EXPECT_EQ(cbrt(-0x1p-147f), -0x1p-49f);
  EXPECT_TRUE(std::isnan(cbrt(nan)));
}

}  // namespace
}  // namespace lockstep
