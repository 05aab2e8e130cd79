// How fast one and two threads read arrays that fit the last-level cache or do not, again and again.
// notes/scaling.md has the figures.
//
//     g++ -std=c++20 -O3 -march=native -ffast-math -fopenmp notes/experiments/last_level_cache.cpp -o build/cache
//     build/cache
#include <omp.h>

#include <algorithm>
#include <cstdio>
#include <limits>
#include <numeric>
#include <vector>

int main() {
  for (const int threads : {1, 2})
    for (const int megabytes : {8, 16, 24, 32, 40, 48, 56, 64, 80, 96, 128, 200}) {
      const std::vector<float> data(megabytes * 1'000'000 / sizeof(float), 1.f);
      const std::size_t each = data.size() / threads;
      double seconds = std::numeric_limits<double>::infinity(), sum = 0;
      for (int repeat = 0; repeat < 30; ++repeat) {
        const double start = omp_get_wtime();
        // A thread reads its own share; the sums are reduced.
#pragma omp parallel num_threads(threads) reduction(+ : sum)
        {
          const float* const own = data.data() + each * omp_get_thread_num();
          sum += std::accumulate(own, own + each, 0.f);
        }
        seconds = std::min(seconds, omp_get_wtime() - start);
      }
      std::printf("%d threads, %d MB: %.1f GB/s (sum %g)\n", threads, megabytes, 1e-3 * megabytes / seconds, sum);
    }
}
