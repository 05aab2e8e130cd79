// Random numbers against the known answers of Random123 (its file kat_vectors), in lanes and not.
#include "common/random.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

#include "openmp/random.h"
#include "serial/random.h"

namespace lockstep {
namespace {

struct Known {
  std::uint32_t counter[4], key[2], random[4];
};
constexpr Known known[] = {
    {{0, 0, 0, 0}, {0, 0}, {0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}},
    {{0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff},
     {0xffffffff, 0xffffffff},
     {0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}},
    {{0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344},
     {0xa4093822, 0x299f31d0},
     {0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}},
};

std::int32_t as_signed(std::uint32_t word) { return static_cast<std::int32_t>(word); }
FourWords<std::int32_t> counter_of(const std::uint32_t (&word)[4]) {
  return {as_signed(word[0]), as_signed(word[1]), as_signed(word[2]), as_signed(word[3])};
}
FourWords<intv> in_all_lanes(const FourWords<std::int32_t>& words) {
  return {words.word[0], words.word[1], words.word[2], words.word[3]};
}

void expect_words(const FourWords<intv>& words, int lane, const FourWords<std::int32_t>& expected) {
  for (int k = 0; k < 4; ++k) {
    std::int32_t word[lanes];
    store(word, words.word[k]);
    EXPECT_EQ(word[lane], expected.word[k]) << "word " << k << " of lane " << lane;
  }
}

TEST(Random, GivesTheKnownAnswers) {
  for (const Known& k : known) {
    const RandomKey key = {{k.key[0], k.key[1]}};
    const FourWords<std::int32_t> counter = counter_of(k.counter), random = philox(counter, key);
    for (int word = 0; word < 4; ++word) EXPECT_EQ(random.word[word], as_signed(k.random[word]));
    for (int lane = 0; lane < lanes; ++lane)
      expect_words(philox(in_all_lanes(counter), key), lane, counter_of(k.random));
  }
}

// Counters and keys that are answers themselves, so that all digits of a product occur.
TEST(Random, HasTheSameWordsInLanes) {
  FourWords<std::int32_t> words = {1, 2, 3, 4};
  for (int trial = 0; trial < 1000; ++trial) {
    const RandomKey key = {{static_cast<std::uint32_t>(words.word[0]), static_cast<std::uint32_t>(words.word[2])}};
    const FourWords<intv> counter = {intv(words.word[0]) + lane_index(), intv(words.word[1]), intv(words.word[2]),
                                     intv(words.word[3]) ^ lane_index()};
    const FourWords<intv> random = philox(counter, key);
    for (int lane = 0; lane < lanes; ++lane) {
      const auto first = as_signed(static_cast<std::uint32_t>(words.word[0]) + lane);
      const FourWords<std::int32_t> of_lane = {first, words.word[1], words.word[2], words.word[3] ^ lane};
      expect_words(random, lane, philox(of_lane, key));
    }
    words = philox(words, key);
  }
}

TEST(Random, MakesNumbersFromZeroToBelowOne) {
  EXPECT_EQ(unit<float>(std::int32_t(0)), 0);
  EXPECT_EQ(unit<float>(std::int32_t(0xff)), 0);
  EXPECT_EQ(unit<float>(std::int32_t(0x100)), 0x1p-24f);
  EXPECT_EQ(unit<float>(std::int32_t(0x7fffffff)), .5f - 0x1p-24f);
  EXPECT_EQ(unit<float>(INT32_MIN), .5f);
  EXPECT_EQ(unit<float>(std::int32_t(-1)), 1 - 0x1p-24f);
  EXPECT_EQ(unit<double>(std::int32_t(-1)), 1 - 0x1p-24);
  float lane[lanes];
  store(lane, unit<floatv>(intv(-1)));
  EXPECT_EQ(lane[15], 1 - 0x1p-24f);
}

}  // namespace
}  // namespace lockstep
