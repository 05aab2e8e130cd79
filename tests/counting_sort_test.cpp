// The stable counting sorts, in sequence and by a team, against std::stable_sort.
#include "openmp/counting_sort.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "common/counting_sort.h"

namespace lockstep {
namespace {

struct Element {
  std::int32_t key, number;
  bool operator==(const Element&) const = default;
};

TEST(CountingSort, IsStableAtEveryThreadCount) {
  const int before = omp_get_max_threads();
  std::mt19937 random(1);
  for (const int keys : {1, 2, 255, 256, 257, 1000, 5000})
    for (const int n : {0, 1, 15, 16, 17, 1000}) {
      SCOPED_TRACE(testing::Message() << keys << " keys, " << n << " elements");
      std::vector<Element> elements(n);
      for (int i = 0; i < n; ++i) elements[i] = {std::uniform_int_distribution(0, keys - 1)(random), i};
      std::vector<Element> expected = elements;
      std::ranges::stable_sort(expected, {}, &Element::key);
      std::vector<std::int32_t> expected_begin(keys + 1);
      for (int key = 0; key <= keys; ++key)
        expected_begin[key] = std::ranges::lower_bound(expected, key, {}, &Element::key) - expected.begin();

      std::vector<Element> sorted(n);
      std::vector<std::int32_t> begin;
      stable_counting_sort(
          keys,
          [&](const auto& visit) {
            for (const Element& element : elements) visit(element, element.key);
          },
          [&](const Element& element, int place) { sorted[place] = element; }, begin);
      EXPECT_EQ(sorted, expected);
      EXPECT_EQ(begin, expected_begin);

      for (const int threads : {1, 2, 3, 4, 8}) {
        omp_set_num_threads(threads);
        sorted.assign(n, {});
        begin.assign(keys + 1, -1);
        openmp::CountingSort sort(keys);
        for (const bool wants_begin : {true, false}) {
          // Each thread has its share; the region's end is the barrier after the sort.
#pragma omp parallel
          {
            const openmp::Share mine = openmp::my_share(n);
            sort(
                [&](const auto& visit) {
                  for (int i = mine.begin; i < mine.end; ++i) visit(elements[i], elements[i].key);
                },
                [&](const Element& element, int place) { sorted[place] = element; },
                wants_begin ? begin.data() : nullptr);
          }
          EXPECT_EQ(sorted, expected);
          EXPECT_EQ(begin, expected_begin);
        }
      }
    }
  omp_set_num_threads(before);
}

}  // namespace
}  // namespace lockstep
