// The benchmark's selection of samples, with a known number of cores for each.
#include "verify/samples.h"

#include <gtest/gtest.h>

namespace lockstep::verify {
namespace {

std::vector<double> seconds_of(const std::vector<Sample>& samples) {
  std::vector<double> seconds;
  for (const Sample& s : samples) seconds.push_back(s.seconds);
  return seconds;
}

TEST(Samples, SetsAsideWhatHadLessThanNineTenthsOfTheCores) {
  const Counted some = counted({{1, 2}, {3, 1.75}, {5, 1.85}}, 2, 15);
  EXPECT_EQ(seconds_of(some.samples), (std::vector<double>{1, 5}));
  EXPECT_FALSE(some.lack_cores);
}

// A short time on half of the cores is dropped like a long one: only the cores decide.
TEST(Samples, DoesNotLookAtTheTimes) {
  EXPECT_EQ(seconds_of(counted({{1, 1}, {9, 2}}, 2, 15).samples), std::vector<double>{9});
}

TEST(Samples, CountsAllWhereFewerThanHalfHadTheCores) {
  const Counted all = counted({{1, 2}, {3, 1}, {5, 1}, {7, 1}}, 2, 15);
  EXPECT_EQ(seconds_of(all.samples), (std::vector<double>{1, 3, 5, 7}));
  EXPECT_TRUE(all.lack_cores);
}

TEST(Samples, AsksForNoMoreThanEnough) {
  std::vector<Sample> samples(100, {3, 1});
  samples[10] = samples[20] = {1, 2};
  EXPECT_EQ(counted(samples, 2, 2).samples.size(), 2u);
  EXPECT_TRUE(counted(samples, 2, 3).lack_cores);
}

TEST(Samples, CountsTheOnlyOneWhateverItHad) {
  const Counted only = counted({{3, 1}}, 2, 1);
  EXPECT_EQ(only.samples.size(), 1u);
  EXPECT_TRUE(only.lack_cores);
}

TEST(Samples, HaveQuantiles) {
  const std::vector<Sample> samples = {{5, 10}, {1, 30}, {4, 20}, {2, 50}, {3, 40}};
  EXPECT_EQ(quantile(samples, &Sample::seconds, 0), 1);
  EXPECT_EQ(quantile(samples, &Sample::seconds, .25), 2);
  EXPECT_EQ(quantile(samples, &Sample::seconds, .5), 3);
  EXPECT_EQ(quantile(samples, &Sample::turns, .75), 40);
}

TEST(Samples, HaveASpreadFromTwoOn) {
  EXPECT_EQ(spread({{3, 1}}), std::nullopt);
  EXPECT_EQ(spread({{3, 1}, {3, 1}}), 0);
  EXPECT_DOUBLE_EQ(spread({{5, 1}, {1, 1}, {4, 1}, {2, 1}, {3, 1}}).value(), 2. / 3);
}

}  // namespace
}  // namespace lockstep::verify
