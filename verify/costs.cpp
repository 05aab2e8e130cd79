#include "verify/costs.h"

#include <omp.h>

#include <algorithm>
#include <fstream>
#include <string>
#include <vector>

#include "common/array.h"
#include "common/simd.h"
#include "verify/report.h"

namespace lockstep::verify {

double triad_gb_per_s(int threads) {
  constexpr int n = 1 << 24;
  Array<float> a(n, 0.f), b(n, 1.f), c(n, 2.f);
  double best = 0;
  for (int repeat = 0; repeat < 5; ++repeat) {
    const double start = now();
    // Every element is one thread's.
#pragma omp parallel for simd num_threads(threads) schedule(static)
    for (int i = 0; i < n; ++i) a[i] = b[i] + 3.f * c[i];
    best = std::max(best, 12. * n / (now() - start) * 1e-9);
  }
  return best;
}

double fma_gflop_per_s(int threads) {
  constexpr int chains = 10, steps = 2'000'000;  // more chains than an FMA's latency times its rate
  double best = 0;
  float sum = 0;
  for (int repeat = 0; repeat < 5; ++repeat) {
    const double start = now();
    // Each thread works on its own registers.
#pragma omp parallel num_threads(threads) reduction(max : sum)
    {
      floatv chain[chains];
      for (int c = 0; c < chains; ++c) chain[c] = floatv(1.f + c);
      for (int step = 0; step < steps; ++step)
        for (floatv& v : chain) v = fma(v, floatv(.999f), floatv(.001f));
      for (const floatv& v : chain) sum = std::max(sum, reduce_max(v));
    }
    best = std::max(best, 2. * lanes * chains * steps * threads / (now() - start) * 1e-9);
  }
  return sum > 0 ? best : 0;  // keeps the chains from being optimised away
}

double last_level_cache() {
  double largest = 0;
  for (int index = 0;; ++index) {
    std::ifstream file("/sys/devices/system/cpu/cpu0/cache/index" + std::to_string(index) + "/size");
    double kib;  // "1024K"
    if (!(file >> kib)) return largest;
    largest = std::max(largest, 1024 * kib);
  }
}

double clock_ns() {
#if defined(__x86_64__)
  // The counter without a fence: a fence waits for all loads before it, which a lock does not, and locks are timed by the million.
  static const double ns_per_tick = [] {
    const double start = now();
    const auto first = __builtin_ia32_rdtsc();
    while (now() < start + .02) continue;
    return 1e9 * (now() - start) / static_cast<double>(__builtin_ia32_rdtsc() - first);
  }();
  return static_cast<double>(__builtin_ia32_rdtsc()) * ns_per_tick;
#else
  return 1e9 * now();
#endif
}

namespace {

// The median over repeats of what `measure` gives.
template <class Measure>
double median(int repeats, const Measure& measure) {
  std::vector<double> found(repeats);
  for (double& f : found) f = measure();
  std::ranges::nth_element(found, found.begin() + repeats / 2);
  return found[repeats / 2];
}

constexpr int repeats = 21;

double fork_join_ns(int threads) {
  constexpr int n = 500;
  return median(repeats, [&] {
    const double start = clock_ns();
    for (int i = 0; i < n; ++i) {
      // Nothing is done.
#pragma omp parallel num_threads(threads)
      asm volatile("");
    }
    return (clock_ns() - start) / n;
  });
}

double barrier_ns(int threads) {
  constexpr int n = 2000;
  return median(repeats, [&] {
    double ns = 0;
    // Nothing is shared but the time, which one thread writes.
#pragma omp parallel num_threads(threads)
    {
#pragma omp barrier
      const double start = clock_ns();
      for (int i = 0; i < n; ++i) {
#pragma omp barrier
      }
#pragma omp master
      ns = clock_ns() - start;
    }
    return ns / n;
  });
}

// To take and give back each of many locks, by the thread that had them last, or by another.
OneAtATime lock_ns() {
  constexpr int n = 128, apart = 64 / sizeof(omp_lock_t) + 1, jump = 37;  // a cache line each, in an order that no prefetch foresees
  std::vector<omp_lock_t> locks(n * apart);
  for (omp_lock_t& lock : locks) omp_init_lock(&lock);
  const auto take_all = [&] {
    const double start = clock_ns();
    for (int i = 0; i < n; ++i) {
      omp_lock_t* const lock = &locks[i * jump % n * apart];
      omp_set_lock(lock);
      omp_unset_lock(lock);
    }
    return (clock_ns() - start) / n;
  };
  OneAtATime cost;
  cost.again = median(repeats, take_all);
  const auto take_from_another = [&] {
    double ns = 0;
    // Threads take turns; the barriers keep them apart.
#pragma omp parallel num_threads(2)
    {
      if (omp_get_thread_num() == 0) take_all();
#pragma omp barrier
      if (omp_get_thread_num() == 1) ns = take_all();
#pragma omp barrier
    }
    return ns;
  };
  cost.moved = omp_get_num_procs() < 2 ? cost.again : median(repeats, take_from_another);
  for (omp_lock_t& lock : locks) omp_destroy_lock(&lock);
  return cost;
}

double dispatch_ns(int threads) {
  constexpr int n = 20000;
  return median(repeats, [&] {
    const double start = clock_ns();
    // Nothing is done but to ask for the next.
#pragma omp parallel for num_threads(threads) schedule(dynamic)
    for (int i = 0; i < n; ++i) asm volatile("");
    return (clock_ns() - start) / n;
  });
}

}  // namespace

void wake_team() {
  // Nothing is done.
#pragma omp parallel
  asm volatile("");
}

double clock_cost_ns() {
  constexpr int n = 10000;
  return median(repeats, [] {
    const double start = clock_ns();
    for (int i = 0; i < n; ++i) clock_ns();
    return (clock_ns() - start) / (n + 1);
  });
}

Costs measure_costs() {
  const int threads = std::min(2, omp_get_num_procs());
  Costs costs;
  costs.fork_join = {fork_join_ns(1), fork_join_ns(threads)};
  costs.barrier = {barrier_ns(1), barrier_ns(threads)};
  costs.lock = lock_ns();
  costs.dispatch = {dispatch_ns(1), dispatch_ns(threads)};
  for (int t = 1; t <= omp_get_num_procs(); t *= 2) costs.bytes_per_ns = std::max(costs.bytes_per_ns, triad_gb_per_s(t));
  return costs;
}

}  // namespace lockstep::verify
