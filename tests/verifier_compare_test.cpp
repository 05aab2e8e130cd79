// The verifier's comparisons, given wrong results: a verifier that cannot fail is worthless.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "verify/compare.h"

namespace lockstep::verify {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();

std::string element(std::size_t k) { return "element " + std::to_string(k); }

// --- Bitwise

Judgement compare_bits(const std::vector<float>& openmp, const std::vector<float>& serial) {
  Judgement judgement{.verdict = Verdict::bitwise, .worst_at = ""};
  same_bits(judgement, std::span<const float>(openmp), std::span<const float>(serial), element);
  return judgement;
}

float with_bit_flipped(float x, int bit) { return std::bit_cast<float>(std::bit_cast<std::uint32_t>(x) ^ 1u << bit); }

TEST(SameBits, PassesOnTheSame) {
  const Judgement judgement = compare_bits({1, -0.f, nan, inf}, {1, -0.f, nan, inf});
  EXPECT_TRUE(judgement.passed);
  EXPECT_EQ(judgement.error, 0);
  EXPECT_EQ(judgement.worst_at, "");
}

TEST(SameBits, FailsOnAnyOneBit) {
  for (int bit = 0; bit < 32; ++bit) EXPECT_FALSE(compare_bits({1, with_bit_flipped(2, bit)}, {1, 2}).passed) << bit;
}

TEST(SameBits, TellsZerosAndNansApart) {
  EXPECT_FALSE(compare_bits({-0.f}, {0.f}).passed);
  EXPECT_FALSE(compare_bits({nan}, {0}).passed);
  EXPECT_FALSE(compare_bits({0}, {nan}).passed);
  EXPECT_FALSE(compare_bits({with_bit_flipped(nan, 0)}, {nan}).passed);
}

TEST(SameBits, CountsAndNamesTheFirst) {
  const Judgement judgement = compare_bits({1, 2.5, 3, 4.5}, {1, 2, 3, 4});
  EXPECT_EQ(judgement.error, 2);
  EXPECT_EQ(judgement.worst_at, "element 1: openmp 2.5, serial 2");
}

TEST(SameBits, KeepsAnEarlierFailure) {
  Judgement judgement{.verdict = Verdict::bitwise, .worst_at = ""};
  const std::vector<float> right = {1}, wrong = {2};
  same_bits(judgement, std::span<const float>(wrong), std::span<const float>(right), element);
  same_bits(judgement, std::span<const float>(right), std::span<const float>(right), element);
  EXPECT_FALSE(judgement.passed);
}

TEST(HashBytes, TellsOneBitAndOrder) {
  const auto hash = [](const std::vector<float>& values) { return hash_bytes(std::span<const float>(values)); };
  EXPECT_EQ(hash({1, 2}), hash({1, 2}));
  EXPECT_NE(hash({1, 2}), hash({2, 1}));
  EXPECT_NE(hash({0.f}), hash({-0.f}));
  for (int bit = 0; bit < 32; ++bit) EXPECT_NE(hash({1, with_bit_flipped(2, bit)}), hash({1, 2}));
}

// --- Bounded

Judgement compare_bounded(const std::vector<float>& openmp, const std::vector<float>& serial,
                          const std::vector<double>& truth, const std::vector<double>& rounding) {
  Judgement judgement{.verdict = Verdict::bounded, .worst_at = ""};
  within_bound(judgement, openmp, serial, truth, rounding, element);
  return judgement;
}

TEST(WithinBound, PassesOnExactlyTheBoundAndFailsJustAbove) {
  // Twice the serial error, .25, and the rounding, .5: exactly 1.
  EXPECT_TRUE(compare_bounded({5}, {4.25}, {4}, {.5}).passed);
  EXPECT_TRUE(compare_bounded({3}, {4.25}, {4}, {.5}).passed);
  EXPECT_FALSE(compare_bounded({std::nextafter(5.f, 6.f)}, {4.25}, {4}, {.5}).passed);
  EXPECT_FALSE(compare_bounded({std::nextafter(3.f, 2.f)}, {4.25}, {4}, {.5}).passed);
  EXPECT_TRUE(compare_bounded({4}, {4}, {4}, {0}).passed);
  EXPECT_FALSE(compare_bounded({std::nextafter(4.f, 5.f)}, {4}, {4}, {0}).passed);
}

TEST(WithinBound, FailsOnNan) {
  EXPECT_FALSE(compare_bounded({nan}, {1}, {1}, {1}).passed);
  EXPECT_FALSE(compare_bounded({1}, {nan}, {1}, {1}).passed);
  EXPECT_FALSE(compare_bounded({1}, {1}, {nan}, {1}).passed);
  EXPECT_FALSE(compare_bounded({1}, {1}, {1}, {nan}).passed);
  EXPECT_FALSE(compare_bounded({nan}, {nan}, {nan}, {1}).passed);
  EXPECT_FALSE(compare_bounded({inf}, {1}, {1}, {1}).passed);
  EXPECT_FALSE(compare_bounded({inf}, {inf}, {1}, {1}).passed);  // a wrong serial result does not excuse openmp
}

TEST(WithinBound, ReportsTheWorstByItsOwnBound) {
  const Judgement good = compare_bounded({1.25, 2.5, 3.25}, {1, 2, 3}, {1, 2, 3}, {1, 100, 1.5});
  EXPECT_TRUE(good.passed);
  EXPECT_EQ(good.worst_at, "element 0: openmp 1.25, serial 1");
  EXPECT_EQ(good.error, .25);
  EXPECT_EQ(good.bound, 1);

  const Judgement bad = compare_bounded({1, 3, 5, 4}, {1, 2, 3, 4}, {1, 2, 3, 4}, {1, .25, 1, 1});
  EXPECT_FALSE(bad.passed);
  EXPECT_EQ(bad.worst_at, "element 1: openmp 3, serial 2");
}

// NaN is the worst error, whatever comes after it.
TEST(WithinBound, ReportsNan) {
  const Judgement judgement = compare_bounded({1, nan, 3.5, 4}, {1, 2, 3, 4}, {1, 2, 3, 4}, {1, 1, 1, 1});
  EXPECT_FALSE(judgement.passed);
  EXPECT_EQ(judgement.worst_at.substr(0, judgement.worst_at.find(':')), "element 1");
}

TEST(WithinBound, KeepsAnEarlierFailure) {
  Judgement judgement{.verdict = Verdict::bounded, .worst_at = ""};
  const std::vector<float> right = {1}, wrong = {2};
  const std::vector<double> truth = {1}, rounding = {.5};
  within_bound(judgement, wrong, right, truth, rounding, element);
  within_bound(judgement, right, right, truth, rounding, element);
  EXPECT_FALSE(judgement.passed);
  EXPECT_EQ(judgement.worst_at, "element 0: openmp 2, serial 1");
}

}  // namespace
}  // namespace lockstep::verify
