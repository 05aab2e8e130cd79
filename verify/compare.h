// The comparisons behind the verdicts: same bits, and within a bound.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "verify/kernel.h"

namespace lockstep::verify {

// u = 2^-24, the largest relative rounding error of float.
inline constexpr double unit_roundoff = std::numeric_limits<float>::epsilon() / 2;

// The name of an element in messages: "particle 12", "cell 3".
using ElementName = std::function<std::string(std::size_t element)>;

// FNV-1a over the bytes of the values, to test whether two runs left the same bits.
template <class T>
std::uint64_t hash_bytes(std::span<const T> values, std::uint64_t hash = 0xcbf29ce484222325) {
  const auto* bytes = reinterpret_cast<const unsigned char*>(values.data());
  for (std::size_t k = 0; k < values.size_bytes(); ++k) hash = (hash ^ bytes[k]) * 0x100000001b3;
  return hash;
}

inline std::string both_values(const std::string& where, double openmp, double serial) {
  char text[120];
  std::snprintf(text, sizeof text, ": openmp %.9g, serial %.9g", openmp, serial);
  return where + text;
}

// Bitwise: asserts that every element has the same bits in both. Adds to what `judgement` already holds.
template <class T>
void same_bits(Judgement& judgement, std::span<const T> openmp, std::span<const T> serial, const ElementName& name) {
  for (std::size_t k = 0; k < serial.size(); ++k) {
    if (std::memcmp(&openmp[k], &serial[k], sizeof(T)) == 0) continue;
    if (judgement.error == 0) judgement.worst_at = both_values(name(k), double(openmp[k]), double(serial[k]));
    judgement.error += 1;
    judgement.passed = false;
  }
}

// Bounded: asserts for every element that it is finite and that |openmp - truth| <= 2 |serial - truth| +
// rounding[element]. Reports the element with the largest error relative to its bound.
inline void within_bound(Judgement& judgement, std::span<const float> openmp, std::span<const float> serial,
                         std::span<const double> truth, std::span<const double> rounding, const ElementName& name) {
  const auto ratio = [](double error, double bound) {
    if (error == 0 && bound >= 0) return 0.;
    return error / bound >= 0 ? error / bound : std::numeric_limits<double>::infinity();  // NaN is worst
  };
  for (std::size_t k = 0; k < truth.size(); ++k) {
    const double error = std::abs(openmp[k] - truth[k]);
    const double bound = 2 * std::abs(serial[k] - truth[k]) + rounding[k];
    const bool within = std::isfinite(openmp[k]) && error <= bound;
    if (!within) judgement.passed = false;
    if (judgement.worst_at.empty() || !(ratio(error, bound) <= ratio(judgement.error, judgement.bound))) {
      judgement.error = error;
      judgement.bound = bound;
      judgement.worst_at = both_values(name(k), openmp[k], serial[k]);
    }
  }
}

}  // namespace lockstep::verify
