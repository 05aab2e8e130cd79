// What a pass of a radix sort costs two threads, one after the other or at once: where they put elements of a digit
// side by side, and where each has an array of its own. notes/scaling.md has the figures.
//
//     g++ -std=c++20 -O2 -march=native -fopenmp notes/experiments/shared_lines.cpp -o build/lines
//     build/lines
#include <omp.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <random>
#include <vector>

namespace {

struct Keyed {
  std::uint32_t key;
  std::int32_t element;
};

constexpr int threads = 2, digits = 256;
using Counts = std::array<int, digits>;

// The least time of each thread, us.
std::array<double, threads> time_pass(int n, bool side_by_side, bool at_once) {
  std::vector<Keyed> from(n), to(2 * n);
  std::mt19937 random(1);
  std::ranges::generate(from, [&, k = 0]() mutable { return Keyed{static_cast<std::uint32_t>(random()), k++}; });
  std::array<Counts, threads> counts = {};
  for (int k = 0; k < n; ++k) ++counts[k / (n / threads)][from[k].key % digits];
  std::array<double, threads> least;
  least.fill(std::numeric_limits<double>::infinity());
  for (int repeat = 0; repeat < 200; ++repeat) {
    // Each thread reads its own half of `from`, and writes places that are its alone.
#pragma omp parallel num_threads(threads)
    {
      const int me = omp_get_thread_num(), other = 1 - me, half = n / threads;
      // As behind an earlier pass, a thread's half and the places are in the other's cache.
      for (int k = half * other; k < half * (other + 1); ++k) from[k].element = k, to[k] = to[n + k] = {};
      Counts place;
      for (int digit = 0, lesser = 0; digit < digits; ++digit) {
        place[digit] = side_by_side ? lesser + (me > 0 ? counts[0][digit] : 0) : n * me + lesser;
        lesser += side_by_side ? counts[0][digit] + counts[1][digit] : counts[me][digit];
      }
      for (int turn = 0; turn < (at_once ? 1 : threads); ++turn) {
#pragma omp barrier
        if (!at_once && turn != me) continue;
        const double start = omp_get_wtime();
        for (int k = half * me; k < half * (me + 1); ++k) to[place[from[k].key % digits]++] = from[k];
        least[me] = std::min(least[me], 1e6 * (omp_get_wtime() - start));
      }
    }
  }
  return least;
}

}  // namespace

int main() {
  for (const int n : {6'000, 24'000, 100'000})
    for (const bool side_by_side : {true, false})
      for (const bool at_once : {false, true}) {
        const auto [first, second] = time_pass(n, side_by_side, at_once);
        std::printf("%6d elements, %s, %s: %.1f and %.1f us\n", n, side_by_side ? "side by side" : "apart",
                    at_once ? "at once" : "one after the other", first, second);
      }
}
