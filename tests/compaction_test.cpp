// Compaction by a team of threads, against std::copy_if.
#include "openmp/compaction.h"

#include <gtest/gtest.h>
#include <omp.h>

#include <random>
#include <vector>

#include "common/array.h"

namespace lockstep::openmp {
namespace {

TEST(Compaction, KeepsTheOrderAtEveryThreadCount) {
  const int threads_before = omp_get_max_threads();
  std::mt19937 random(1);
  for (const int n : {0, 1, 15, 16, 17, 1008, 1023, 1024, 1025, 2048, 5000})
    for (const double share : {0., .01, .5, .99, 1.}) {
      SCOPED_TRACE(testing::Message() << n << " elements, of which " << share);
      Array<float> from(padded(n));
      std::vector<float> expected;
      std::vector<int> before(n + 1);
      std::vector<bool> is_chosen(n);
      for (int i = 0; i < n; ++i) {
        from[i] = static_cast<float>(i);
        is_chosen[i] = std::bernoulli_distribution(share)(random);
        before[i] = static_cast<int>(expected.size());
        if (is_chosen[i]) expected.push_back(from[i]);
      }
      before[n] = static_cast<int>(expected.size());
      for (const int threads : {1, 2, 3, 8}) {
        omp_set_num_threads(threads);
        Compaction chosen(n);
        // A chunk chooses among its own elements.
#pragma omp parallel for
        for (int chunk = 0; chunk < chosen.chunks(); ++chunk)
          chosen.for_each_sixteen(chunk, [&](int i) {
            std::uint32_t which = i + lanes > n ? 0xffffu << (n - i) & 0xffff : 0;  // those beyond the end
            for (int k = i; k < std::min(i + lanes, n); ++k) which |= std::uint32_t(is_chosen[k]) << (k - i);
            chosen.choose(i, lanes_of(which));
          });
        ASSERT_EQ(chosen.add_up(), int(expected.size()));
        for (int i = 0; i <= n; ++i) ASSERT_EQ(chosen.before_any(i), before[i]) << i;
        Array<float> to(expected.size() + 1, -1);  // no room beyond the chosen ones but for a guard
                                                   // A chunk's elements go to places of their own.
#pragma omp parallel for
        for (int chunk = 0; chunk < chosen.chunks(); ++chunk)
          chosen.for_each_sixteen(chunk, [&](int i) { chosen.move(i, {{from.data(), to.data()}}); });
        for (std::size_t k = 0; k < expected.size(); ++k) ASSERT_EQ(to[k], expected[k]) << k;
        EXPECT_EQ(to.back(), -1);
      }
    }
  omp_set_num_threads(threads_before);
}

}  // namespace
}  // namespace lockstep::openmp
