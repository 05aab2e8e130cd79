// common/simd_records.h, of the one back end it is built for: every function has the bits of the scalar expression that
// the header promises.

#include "common/simd_records.h"

#include <gtest/gtest.h>

#include <bit>
#include <limits>

#include "tests/simd_values.h"

namespace lockstep {
namespace {

TEST(SimdRecords, LoadsNumbersOneByOne) {
  float numbers[100];
  for (int k = 0; k < 100; ++k) numbers[k] = static_cast<float>(3 * k);
  std::int32_t index[lanes];
  for (int l = 0; l < lanes; ++l) index[l] = 37 * l % 64 - 40;
  const auto got = values(load_each(numbers + 50, index));
  for (int l = 0; l < lanes; ++l) EXPECT_EQ(got[l], numbers[50 + index[l]]) << l;
}

TEST(SimdRecords, ChoosesFromTwoVectors) {
  float a[lanes], b[lanes];
  std::uint16_t place[lanes];
  for (int l = 0; l < lanes; ++l) {
    a[l] = static_cast<float>(l), b[l] = static_cast<float>(100 + l);
    place[l] = static_cast<std::uint16_t>(4001 * (l + 1));  // of which five bits count
  }
  const auto got = values(choose(load(a), load(b), load_wide(place)));
  for (int l = 0; l < lanes; ++l) EXPECT_EQ(got[l], (place[l] & 16 ? b : a)[place[l] & 15]) << l;
}

// At any alignment; and what stands before and behind stays as it is.
TEST(SimdRecords, LoadsAndStoresSixteenQuads) {
  constexpr int count = 4 * lanes + 2;
  for (int begin = 0; begin <= 2; ++begin) {
    float from[count], to[count];
    for (int k = 0; k < count; ++k) from[k] = static_cast<float>(k + 1), to[k] = -1;
    const Quads quads = load_sixteen_quads(from + begin);
    for (int f = 0; f < 4; ++f)
      for (int l = 0; l < lanes; ++l) EXPECT_EQ(values(quads.field[f])[l], from[begin + 4 * l + f]) << f << " " << l;
    store_sixteen_quads(to + begin, quads);
    for (int k = 0; k < count; ++k)
      EXPECT_EQ(to[k], k >= begin && k < begin + 4 * lanes ? from[k] : -1) << begin << " " << k;
  }
}

TEST(SimdRecords, ComparesRecords) {
  constexpr float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  alignas(32) const float a[8] = {1, 2, -3, 0, nan, 1, infinity, -infinity}, b[8] = {2, 1, -3, -0.f, 1, nan, 5, 5};
  alignas(32) float least[8], greatest[8];
  store_record(least, min(load_record(a), load_record(b))), store_record(greatest, max(load_record(a), load_record(b)));
  const std::uint32_t is_less = less(load_record(a), load_record(b));
  EXPECT_EQ(is_less >> 8, 0u);
  for (int f = 0; f < 8; ++f) {
    EXPECT_EQ(std::bit_cast<std::uint32_t>(least[f]), std::bit_cast<std::uint32_t>(a[f] < b[f] ? a[f] : b[f])) << f;
    EXPECT_EQ(std::bit_cast<std::uint32_t>(greatest[f]), std::bit_cast<std::uint32_t>(a[f] > b[f] ? a[f] : b[f])) << f;
    EXPECT_EQ(is_less >> f & 1, a[f] < b[f] ? 1u : 0u) << f;
  }
}

}  // namespace
}  // namespace lockstep
