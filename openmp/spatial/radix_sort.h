// Sorts bounded elements by a key, in parallel.
//
// A radix sort from the lowest digit up. In each pass a thread puts its share of the order so far in the order of the
// next digit, in places of its own: there its elements of one digit are a run. The order of all is that of the runs,
// digit by digit, and thread by thread within a digit; a thread's share of it is read run by run. If each thread wrote
// its elements where they belong in the order of all, two threads would write to most cache lines of a short array
// (notes/scaling.md). Keys, passes and order are one parallel region, because starts of regions and barriers are what
// short sorts wait for.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "common/array.h"
#include "common/math.h"
#include "common/simd.h"
#include "common/spatial/bounds.h"
#include "openmp/share.h"
#include "openmp/spatial/boxes.h"
#include "openmp/spatial/workspace.h"

namespace lockstep::spatial::openmp {

// The bits of an unsigned integer in the order of the numbers; -0 counts as 0. Of a number or of lanes.
template <class Number>
inline auto key_of(const Number& x) {
  const auto bits = bits_of(x + Number(0.f));
  return bits ^ (bits >> 31 | std::numeric_limits<std::int32_t>::min());
}

class RadixSort {
 public:
  // Allocates, so it is made outside of parallel regions.
  RadixSort() : runs_(std::make_unique_for_overwrite<std::int32_t[]>(2 * pitch * omp_get_max_threads())) {}

  static constexpr int passes(int bits) { return (bits + digit_bits - 1) / digit_bits; }

  // Puts the n elements of `from` in the order of the lowest `bits` bits of their keys; equal ones keep their order.
  // All threads of a team call it, with the same pointers; each has written its share of `from`. At its end, which is a
  // barrier, `from` is what is sorted, and `to` the other array: they are exchanged once a pass, and once more.
  void operator()(int n, int bits, Keyed*& from, Keyed*& to) {
    const lockstep::openmp::Share mine = lockstep::openmp::my_share(n);
    sort_mine(mine, 0, from, to, [&](const auto& f) { f(mine.begin, mine.end); });
    std::swap(from, to);
    for (int pass = 1; pass < passes(bits); ++pass) {
      sort_mine(mine, pass, from, to, [&](const auto& f) { for_each_run(mine, pass - 1, f); });
      std::swap(from, to);
    }
    Keyed* out = to + mine.begin;
    for_each_run(mine, passes(bits) - 1, [&](int begin, int end) { out = std::copy(from + begin, from + end, out); });
    std::swap(from, to);
    // Each thread has written its own share; from here on the others read it.
#pragma omp barrier
  }

 private:
  static constexpr int digit_bits = 8, digits = 1 << digit_bits;
  static constexpr std::size_t pitch = padded(digits + 1);  // a thread's runs share no cache line with another's

  // Where the runs of a thread begin, digit by digit, and where the last one ends. While a pass writes them, other
  // threads still read those of the pass before.
  std::int32_t* runs_of(int thread, int pass) const { return runs_.get() + pitch * (2 * thread + pass % 2); }

  // Puts the calling thread's share in the order of the pass's digit. source(f) calls f(begin, end) for the places that
  // hold it in `from`, in order.
  template <class Source>
  void sort_mine(lockstep::openmp::Share mine, int pass, const Keyed* from, Keyed* to, const Source& source) {
    const auto digit_of = [&](int k) { return from[k].key >> digit_bits * pass & (digits - 1); };
    std::array<std::int32_t, digits> place = {};
    source([&](int begin, int end) {
      for (int k = begin; k < end; ++k) ++place[digit_of(k)];
    });
    std::int32_t* const run = runs_of(omp_get_thread_num(), pass);
    std::int32_t next = mine.begin;
    for (int digit = 0; digit < digits; ++digit) {
      const std::int32_t count = place[digit];
      run[digit] = place[digit] = next;
      next += count;
    }
    run[digits] = next;
    source([&](int begin, int end) {
      for (int k = begin; k < end; ++k) to[place[digit_of(k)]++] = from[k];
    });
    // Each thread has moved its own share; from here on the others read it, and its runs.
#pragma omp barrier
  }

  // Calls f(begin, end) for the places that hold the calling thread's share of the order of all after a pass, in order.
  template <class F>
  void for_each_run(lockstep::openmp::Share mine, int pass, const F& f) const {
    const int threads = omp_get_num_threads();
    std::array<std::int32_t, digits + 1> first = {};  // of a digit in the order of all, plus `beginnings`
    for (int t = 0; t < threads; ++t)
      for (int digit = 0; digit <= digits; ++digit) first[digit] += runs_of(t, pass)[digit];
    const std::int32_t beginnings = first[0];  // of the shares of all threads, added up
    // A thread that has all elements has them in order.
    if (mine.end - mine.begin == first[digits] - beginnings) return f(mine.begin, mine.end);
    int digit = static_cast<int>(std::ranges::upper_bound(first, beginnings + mine.begin) - first.begin()) - 1;
    int begin = 0, end = 0;  // runs that follow one another are passed on as one
    for (int at = first[digit] - beginnings; at < mine.end; ++digit)
      for (int t = 0; t < threads && at < mine.end; ++t) {
        const std::int32_t* const run = runs_of(t, pass) + digit;
        const int skipped = std::max(mine.begin - at, 0), count = run[1] - run[0];
        const int here = std::min(count, mine.end - at);
        at += count;
        if (skipped >= here) continue;
        if (run[0] + skipped != end) {
          f(begin, end);
          begin = run[0] + skipped;
        }
        end = run[0] + here;
      }
    f(begin, end);
  }

  std::unique_ptr<std::int32_t[]> runs_;  // [thread][parity of the pass][digit]
};

// Puts the bounded elements in the order of their keys, equal ones by number. key(i) has the keys of elements i to
// i + 15, unsigned and less than 2^bits - 1. Out: order, resized; returns the same with the keys, which the next call
// overwrites.
template <class Key>
std::span<const Keyed> sort_by_key(const Bounds<float>& bounds, int bits, const Key& key,
                                   std::vector<std::int32_t>& order) {
  const std::uint32_t last = static_cast<std::uint32_t>((std::uint64_t{1} << bits) - 1);
  Array<Keyed>&keyed = workspace().radix_sort.keyed, &other = workspace().radix_sort.other;
  int n = bounds.count;
  grow(keyed, n);
  grow(other, n);
  order.resize(n);
  RadixSort sort;

  // Each thread reads and writes its own share of keys and order, and moves where the sort tells it; the barriers stand
  // between one thread's writing and another's reading.
#pragma omp parallel
  {
    const lockstep::openmp::Share mine = lockstep::openmp::my_share(n);
    Keyed *from = keyed.data(), *to = other.data();
    for (int i = mine.begin; i < mine.end; i += lanes) {
      alignas(array_alignment) std::int32_t keys[lanes];
      store(keys, select(bounded(load_boxes(bounds, i)), key(i), static_cast<std::int32_t>(last)));
      for (int l = 0; l < std::min(lanes, mine.end - i); ++l)
        from[i + l] = {static_cast<std::uint32_t>(keys[l]), i + l};
    }
    sort(n, bits, from, to);
    for (int k = mine.begin; k < mine.end; ++k) order[k] = from[k].element;
  }
  if (RadixSort::passes(bits) % 2 == 0) keyed.swap(other);
  while (n > 0 && keyed[n - 1].key == last) --n;
  order.resize(n);
  return {keyed.data(), static_cast<std::size_t>(n)};
}

}  // namespace lockstep::spatial::openmp
