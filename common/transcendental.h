// Natural logarithm, exponential and cube root, written once for a float and for sixteen: the same bits on every
// machine, back end and compiler, since only operations that IEEE 754 rounds in one way take part, in one order.
//
//   log(x)   within 0.88 ulp of ln x   log(+-0) = -inf, log(x < 0) = NaN, log(inf) = inf
//   exp(x)   within 0.84 ulp of e^x    0.92 where that is a denormal; 0 below -103.98, inf above 88.73
//   cbrt(x)  within 0.60 ulp           odd; cbrt(+-0) = +-0, cbrt(+-inf) = +-inf; exact for cubes
//
// A NaN gives a NaN. Denormal arguments are numbers like all others. The bounds are derived at each function, and
// tests/transcendental_test.cpp holds floats of every exponent to them; the worst it met were 0.68, 0.78 and 0.53 ulp.
//
// Where the rounding of a sum would show, its error is computed, too, and joins the small terms. Fast two-sum: of
// s = a + b with |a| >= |b|, the error is b - (s - a), exactly.
//
// In double, in which serial text computes the truth, these are the library's functions.
//
// Source: argument reduction and compensation as in W. J. Cody, W. Waite, Software Manual for the Elementary Functions,
// 1980. The polynomials are minimax, found by Remez' exchange in 40 digits.
#pragma once

#include <cmath>
#include <concepts>
#include <limits>

#include "common/math.h"

namespace lockstep {

inline double log(double x) { return std::log(x); }
inline double exp(double x) { return std::exp(x); }
inline double cbrt(double x) { return std::cbrt(x); }

// A float, or lanes of it.
template <class V>
concept SinglePrecision = requires(V x) {
  { float_of_bits(bits_of(x)) } -> std::same_as<V>;
};

// The polynomial of these coefficients, that of the highest power first, by Horner's rule.
template <class V, std::same_as<float>... Coefficients>
V polynomial(V x, float highest, Coefficients... others) {
  V p = V(highest);
  ((p = p * x + V(others)), ...);
  return p;
}

// ln 2 in two parts. The first has 15 bits, so that its product with an exponent is exact.
inline constexpr float ln2_high = 0x1.62e4p-1f, ln2_low = 0x1.7f7d1cp-20f;

// x = 2^e m, m from sqrt(1/2) to sqrt(2), f = m - 1, and log x = e ln 2 + f - f^2 / 2 + f^3 p(f).
//
// e ln2_high, f and the larger part of f^2 / 2 are added without error. The error of the rest is largest, in ulp of the
// result, where f = sqrt(2) - 1 and the result is 0.35 with an ulp of 2^-25. There the cubic term is 0.018. Nine
// roundings of it give 0.33 ulp, p, which is off by 7.6e-10 / f^3, gives 0.03, smaller parts 0.02, and the last
// rounding 0.5.
template <SinglePrecision V>
V log(V x) {
  constexpr float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
  const V positive = abs(x);
  const auto is_denormal = positive < V(0x1p-126f);
  const V normal = select(is_denormal, positive * V(0x1p23f), positive);
  const auto e = (bits_of(normal) - bits_of(V(0x1.6a09e6p-1f))) >> 23;  // of sqrt(1/2)
  const V exponent = to_float(select(is_denormal, e - 23, e));
  const V f = float_of_bits(bits_of(normal) - (e << 23)) - V(1);

  const V f_high = float_of_bits(bits_of(f) & ~0xfff), f_low = f - f_high;  // of 12 bits each
  const V half_square = V(.5f) * f_high * f_high, half_square_low = V(.5f) * f_low * (f + f_high);
  const V p = polynomial(f, 0x1.1b7c70p-4f, -0x1.e28994p-4f, 0x1.e5feeap-4f, -0x1.fb4feep-4f, 0x1.2339dep-3f,
                         -0x1.5562b4p-3f, 0x1.99a4dap-3f, -0x1.ffffeep-3f, 0x1.555546p-2f);
  const V cubic = f * f * f * p;

  const V m = f - half_square, m_error = (f - m) - half_square;
  const V high = exponent * V(ln2_high), sum = high + m, sum_error = m - (sum - high);
  const V result = sum + (sum_error + (m_error + ((cubic - half_square_low) + exponent * V(ln2_low))));
  return select(x > V(0), select(x < V(inf), result, x), select(x == V(0), V(-inf), V(nan)));
}

// x = n ln 2 + r, |r| <= ln 2 / 2, and e^x = 2^n (1 + r + r^2 p(r)).
//
// 1 + r is added without error, and r is known beyond its last bit. The error of the rest is largest, in ulp of the
// result, where r = -ln 2 / 2 and the sum is 0.71 with an ulp of 2^-24. There the square term is 0.054. Five roundings
// of it give 0.27 ulp, p, which is off by 3.2e-9 / r^2, gives 0.05, smaller parts 0.02, and the last rounding 0.5. A
// denormal result is rounded once more, by at most 0.5 of its ulp, which is at least twice the ulp of before.
template <SinglePrecision V>
V exp(V x) {
  const V bounded = max(V(-104), min(V(89), x));  // keeps a NaN, see min
  const V magic = V(0x1.8p23f);  // added to a small number, leaves it rounded to a whole one in the last bits
  const V shifted = bounded * V(0x1.715476p+0f) + magic;
  const V n = shifted - magic;
  const auto whole = bits_of(shifted) - bits_of(magic), half = whole >> 1;

  const V high = bounded - n * V(ln2_high), low = n * V(ln2_low);
  const V r = high - low, r_error = (high - r) - low;
  const V p = polynomial(r, 0x1.6db336p-10f, 0x1.123ad4p-7f, 0x1.555446p-5f, 0x1.555490p-3f, 0x1.000000p-1f);
  const V sum = V(1) + r, sum_error = r - (sum - V(1));
  const V result = sum + (sum_error + (r * r * p + r_error));
  const auto power_of_two = [](auto k) { return float_of_bits((k + 127) << 23); };
  return result * power_of_two(half) * power_of_two(whole - half);  // 2^n itself may be no float
}

// |x| = 2^(3 k) m, m from 1 to 8, t near the cube root of m, z = (m - t^3) / t^3, and cbrt x = 2^k (t + t z p(z)).
//
// t is a polynomial of m, off by at most 2^-9 of itself, then rounded to 8 bits. So t^3 has 24 bits and is exact, and
// so is m - t^3; |z| <= 3 (2^-9 + 2^-8) < 0.018. In ulp of the result, five roundings of t z p, which is at most 0.006
// t, give 0.06, p, which is off by 1.1e-9 / z, gives 0.02, and the last rounding 0.5. The root of a cube is a float: an
// error of 0.08 ulp before the last rounding leaves it exact.
template <SinglePrecision V>
V cbrt(V x) {
  const V positive = abs(x);
  const auto is_denormal = positive < V(0x1p-126f);
  const auto bits = bits_of(select(is_denormal, positive * V(0x1p24f), positive));
  const auto exponent = (bits >> 23) + 2;    // that of |x| + 129, a multiple of 3
  const auto third = (exponent * 171) >> 9;  // rounded down, up to 511
  const V m = float_of_bits((bits & 0x7fffff) | (exponent - third * 3 + 127) << 23);
  const auto k = select(is_denormal, third - 8, third) - 43;

  const V near_root = polynomial(m, -0x1.c51736p-12f, 0x1.3a0aecp-7f, -0x1.572490p-4f, 0x1.cbf978p-2f, 0x1.412cc4p-1f);
  const V t = float_of_bits((bits_of(near_root) + 0x8000) & ~0xffff);
  const V cube = t * t * t, z = (m - cube) / cube;
  const V p = polynomial(z, 0x1.f9d1a4p-5f, -0x1.c72abep-4f, 0x1.555556p-2f);
  const V root = (t + t * z * p) * float_of_bits((k + 127) << 23);

  const V result = float_of_bits(bits_of(root) | (bits_of(x) & ~0x7fffffff));
  return select((x != V(0)) & (positive < V(std::numeric_limits<float>::infinity())), result, x + x);
}

}  // namespace lockstep
