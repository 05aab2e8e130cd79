// The stable counting sort of a team of threads. In sequence: common/counting_sort.h.
//
// Each thread counts the keys of its own share of the elements. An exclusive scan over the keys and, within a key, over
// the threads in order says where a thread's first element of each key goes. Then each thread moves its own elements.
// Shares are contiguous and taken in order, so the sort is stable and its result does not depend on the number of
// threads.
//
// With few keys every thread does the whole scan for itself, which is quicker than a barrier, and works in local
// arrays, which is quicker than in shared memory (a radix sort of 10,000 takes 82 us instead of 91). With many keys the
// threads share the scan out. The counts take threads x keys x 4 bytes either way.
//
// Source: Blelloch, Prefix Sums and Their Applications (1990); Satish, Harris and Garland, Designing Efficient Sorting
// Algorithms for Manycore GPUs (2009).
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <utility>

#include "common/array.h"
#include "openmp/share.h"

namespace lockstep::openmp {

class CountingSort {
 public:
  static constexpr int few_keys = 256;

  // For keys 0 .. keys - 1. Allocates, so it is made outside of parallel regions.
  explicit CountingSort(int keys)
      : keys_(keys),
        pitch_(padded(std::max(keys, few_keys))),
        counts_(std::make_unique_for_overwrite<std::int32_t[]>(pitch_ * omp_get_max_threads())),
        totals_(std::make_unique_for_overwrite<std::int32_t[]>(omp_get_max_threads())) {}

  // Sorts once. All threads of a team call it, each with its own elements: for_each and put are as in
  // common/counting_sort.h. begin is null or has keys + 1 elements, which the team fills.
  //
  // A barrier must follow before a thread reads what others put, or begin, or sorts again.
  template <class ForEach, class Put>
  void operator()(const ForEach& for_each, const Put& put, std::int32_t* begin = nullptr) {
    if (keys_ <= few_keys)
      sort_few(for_each, put, begin);
    else
      sort_many(for_each, put, begin);
  }

 private:
  using Few = std::array<std::int32_t, few_keys>;

  template <class ForEach, class Put>
  void sort_few(const ForEach& for_each, const Put& put, std::int32_t* begin) {
    Few count = {};
    for_each([&](const auto&, std::int32_t key) { ++count[key]; });
    std::ranges::copy(count, of_thread(omp_get_thread_num()));
    // Each thread has written its own counts; from here on all threads read them.
#pragma omp barrier
    Few place = places(begin);
    for_each([&](const auto& element, std::int32_t key) { put(element, place[key]++); });
  }

  template <class ForEach, class Put>
  void sort_many(const ForEach& for_each, const Put& put, std::int32_t* begin) {
    std::int32_t* const count = of_thread(omp_get_thread_num());
    std::fill_n(count, keys_, 0);
    for_each([&](const auto&, std::int32_t key) { ++count[key]; });
    // Each thread has written its own counts; from here on other threads turn them into places.
#pragma omp barrier
    turn_into_places(begin);
    for_each([&](const auto& element, std::int32_t key) { put(element, count[key]++); });
  }

  std::int32_t* of_thread(int thread) const { return counts_.get() + pitch_ * thread; }

  // Where the calling thread's first element of each key goes: behind all elements of lesser keys, and behind those of
  // the threads before it.
  Few places(std::int32_t* begin) const {
    const int thread = omp_get_thread_num();
    Few all = {}, place = {};
    for (int t = 0; t < omp_get_num_threads(); ++t) {
      if (t == thread) place = all;
      for (int key = 0; key < few_keys; ++key) all[key] += of_thread(t)[key];
    }
    std::int32_t lesser = 0;
    for (int key = 0; key < few_keys; ++key) place[key] += std::exchange(lesser, lesser + all[key]);
    if (begin != nullptr && thread == 0) {
      std::copy_n(place.begin(), keys_, begin);
      begin[keys_] = lesser;
    }
    return place;
  }

  // The same for all threads, in place of the counts. Each thread scans its own share of the keys, and adds what stands
  // before that share; the barriers stand between one thread's writing and another's reading.
  void turn_into_places(std::int32_t* begin) {
    const int thread = omp_get_thread_num(), threads = omp_get_num_threads();
    const Share mine = my_share(keys_);
    std::int32_t total = 0;
    for (int key = mine.begin; key < mine.end; ++key)
      for (int t = 0; t < threads; ++t) total += std::exchange(of_thread(t)[key], total);
    totals_[thread] = total;
#pragma omp barrier
    std::int32_t before = 0;
    for (int t = 0; t < thread; ++t) before += totals_[t];
    for (int key = mine.begin; key < mine.end; ++key) {
      for (int t = 0; t < threads; ++t) of_thread(t)[key] += before;
      if (begin != nullptr) begin[key] = of_thread(0)[key];
    }
    if (begin != nullptr && thread + 1 == threads) begin[keys_] = before + total;
#pragma omp barrier
  }

  int keys_;
  std::size_t pitch_;                       // a thread's counts share no cache line with another's
  std::unique_ptr<std::int32_t[]> counts_;  // [thread][key]
  std::unique_ptr<std::int32_t[]> totals_;  // [thread]: elements of its share of the keys
};

}  // namespace lockstep::openmp
