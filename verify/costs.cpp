#include "verify/costs.h"

#include <omp.h>

#include <algorithm>
#include <fstream>
#include <string>
#include <vector>

#include "common/array.h"
#include "common/flags.h"
#include "common/simd.h"
#include "common/waiting.h"
#include "verify/held_team.h"
#include "verify/program.h"

namespace lockstep::verify {

double triad_gb_per_s(int threads) {
  constexpr int n = 1 << 24;
  Array<float> a(n, 0.f), b(n, 1.f), c(n, 2.f);
  double best = 0;
  for (int repeat = 0; repeat < 5; ++repeat) {
    const double start = now();
    // Each element is written by one thread.
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

double turns_per_ns(int threads) {
  int hits = 0;
  double per_ns = 0;
  // The first iterations do not count: vector units that were idle for long take some microseconds to reach full speed.
  for (const int turns : {10'000, 30'000}) {
    const double start = now();
    // Each thread works on its own registers.
#pragma omp parallel num_threads(threads) reduction(+ : hits)
    for (int turn = 0; turn < turns; ++turn) {
      const floatv t(static_cast<float>(turn));
      const maskv hit =
          (floatv(1.f) <= t) & (floatv(2.f) <= t) & (floatv(3.f) <= t) & (t <= floatv(.5f)) & (t <= floatv(.1f));
      if (any(hit)) ++hits;
    }
    per_ns = threads * turns / (1e9 * (now() - start));
  }
  return hits == 0 ? per_ns : 0;  // tested so that the loop is not optimised away
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
  // The counter is read without a fence. A fence waits for all earlier loads, a lock does not, and locks are timed by
  // the million.
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

double median(std::vector<double> values) {
  const auto middle = values.begin() + values.size() / 2;
  std::ranges::nth_element(values, middle);
  return *middle;
}

// The median of the results of `repeats` calls of `measure`.
template <class Measure>
double median(int repeats, const Measure& measure) {
  std::vector<double> found(repeats);
  for (double& f : found) f = measure();
  return median(found);
}

constexpr int repeats = 21;

double fork_join_ns(int threads) {
  constexpr int n = 500;
  return median(repeats, [&] {
    const double start = clock_ns();
    for (int i = 0; i < n; ++i) {
      // The region is empty.
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
    // Threads share only `ns`, which one thread writes.
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

// One thread waits at a barrier for `waited` ns, and another comes then: how late each goes on, beyond the cost of a
// barrier.
Waking::Late late_after(double waited, double barrier) {
  std::vector<double> waiting(repeats), waker(repeats);
  for (int k = 0; k < repeats; ++k) {
    double opened = 0;
    // Each thread writes its own times; one sets `opened`, which is read when both have ended.
#pragma omp parallel num_threads(2)
    {
      const bool is_last = omp_get_thread_num() == 0;
#pragma omp barrier
      for (const double start = clock_ns(); is_last && clock_ns() < start + waited;) continue;
      if (is_last) opened = clock_ns();
#pragma omp barrier
      (is_last ? waker : waiting)[k] = clock_ns();
    }
    waiting[k] -= opened + barrier, waker[k] -= opened + barrier;
  }
  return {std::max(0., median(waiting)), std::max(0., median(waker))};
}

// The extra cost of a lock that another thread held last, over a lock that this thread held last. The loop adds to a
// cache line under each of many locks; the cost of a lock is the time beyond a loop that only adds. The line is there
// because a lock waits for the stores before it.
double lock_moved_ns() {
  constexpr int n = 128, apart = 64 / sizeof(omp_lock_t) + 1,
                jump = 37;  // one cache line each, in an order that defeats the prefetcher
  std::vector<omp_lock_t> locks(n * apart);
  for (omp_lock_t& lock : locks) omp_init_lock(&lock);
  Array<float> guarded(n * lanes, 0.f);
  const auto add_to_all = [&](bool under_locks) {
    const double start = clock_ns();
    for (int i = 0; i < n; ++i) {
      const int at = i * jump % n;
      if (under_locks) omp_set_lock(&locks[at * apart]);
      store(&guarded[at * lanes], load(&guarded[at * lanes]) + floatv(1.f));
      if (under_locks) omp_unset_lock(&locks[at * apart]);
    }
    return (clock_ns() - start) / n;
  };
  const auto by_same = [&](bool under_locks) { return median(repeats, [&] { return add_to_all(under_locks); }); };
  const auto by_another = [&](bool under_locks) {
    return median(repeats, [&] {
      double ns = 0;
      // Threads take turns; the barriers keep them apart.
#pragma omp parallel num_threads(2)
      {
        if (omp_get_thread_num() == 0) add_to_all(under_locks);
#pragma omp barrier
        if (omp_get_thread_num() == 1) ns = add_to_all(under_locks);
#pragma omp barrier
      }
      return ns;
    });
  };
  const double moved = omp_get_num_procs() < 2
                           ? 0
                           : std::max(0., by_another(true) - by_another(false) - (by_same(true) - by_same(false)));
  for (omp_lock_t& lock : locks) omp_destroy_lock(&lock);
  return moved;
}

// From a thread's post until the other has seen it: two threads answer each other.
double flag_seen_ns() {
  constexpr int n = 2000;
  return median(repeats, [&] {
    Flag flags[2];
    double ns = 0;
    // Each thread posts its own flag, and awaits the other's.
#pragma omp parallel num_threads(2)
    {
      const int mine = omp_get_thread_num();
#pragma omp barrier
      const double start = clock_ns();
      for (int i = 1; i <= n; ++i) {
        if (mine == 0) post(flags[0], i);
        await(flags[1 - mine], i);
        if (mine == 1) post(flags[1], i);
      }
#pragma omp master
      ns = clock_ns() - start;
    }
    return ns / (2 * n);
  });
}

// To await a flag that another thread posted before, in a loop that awaits many of them and adds to a cache line for
// each, beyond a loop that only adds.
double flag_read_ns() {
  constexpr int n = 128, jump = 37;  // as for locks
  std::vector<Flag> flags(n);
  Array<float> lines(n * lanes, 0.f);
  int value = 0;
  const auto add_to_all = [&](bool awaits) {
    const double start = clock_ns();
    for (int i = 0; i < n; ++i) {
      const int at = i * jump % n;
      if (awaits) await(flags[at], value);
      store(&lines[at * lanes], load(&lines[at * lanes]) + floatv(1.f));
    }
    return (clock_ns() - start) / n;
  };
  const double beyond = median(repeats, [&] {
    double ns = 0;
    ++value;
    // Thread 0 posts; behind the barrier thread 1 works on its own lines.
#pragma omp parallel num_threads(2)
    {
      if (omp_get_thread_num() == 0)
        for (Flag& flag : flags) post(flag, value);
#pragma omp barrier
      if (omp_get_thread_num() == 1) {
        const double only_adds = add_to_all(false);
        ns = add_to_all(true) - only_adds;
      }
    }
    return ns;
  });
  return std::max(0., beyond);
}

double dispatch_ns(int threads) {
  constexpr int n = 20000;
  return median(repeats, [&] {
    const double start = clock_ns();
    // The iterations are empty: only the fetches of chunks cost time.
#pragma omp parallel for num_threads(threads) schedule(dynamic)
    for (int i = 0; i < n; ++i) asm volatile("");
    return (clock_ns() - start) / n;
  });
}

}  // namespace

void wake_team() {
  // The region is empty.
#pragma omp parallel
  asm volatile("");
}

// The extra time of a loop that adds to cache lines and reads the clock each time, over a loop that only adds. Measured
// this way because the processor overlaps much of the two.
double clock_cost_ns() {
  constexpr int n = 128, jump = 37;
  Array<float> lines(n * lanes, 0.f);
  const auto add_to_all = [&](bool read_clock) {
    double last = 0;
    const double start = clock_ns();
    for (int i = 0; i < n; ++i) {
      float* const line = &lines[i * jump % n * lanes];
      store(line, load(line) + floatv(1.f));
      if (read_clock) last = clock_ns();
      asm volatile("" : : "x"(last));
    }
    return (clock_ns() - start) / n;
  };
  return median(repeats, [&] { return add_to_all(true); }) - median(repeats, [&] { return add_to_all(false); });
}

Costs measure_costs() {
  const int threads = std::min(2, omp_get_num_procs()), threads_before = omp_get_max_threads();
  Costs costs;
  // On the teams that rows run on: one thread is never held, two are.
  hold_team(1, [&] {
    costs.fork_join.one = fork_join_ns(1);
    costs.barrier.one = barrier_ns(1);
    costs.dispatch.again = dispatch_ns(1);
  });
  hold_team(threads, [&] {
    costs.fork_join.two = fork_join_ns(threads);
    costs.barrier.two = barrier_ns(threads);
    if (threads == 2) {
      // The middle of the time in which a thread yields, of that in which it falls asleep, and well behind both.
      const auto after_us = [&](double waited) { return late_after(1e3 * waited, costs.barrier.two); };
      costs.waking = {.from_yielding = after_us((turning_us + patience_us) / 2.).waiting,
                      .falling_asleep = after_us(patience_us + falling_asleep_us / 2.),
                      .asleep = after_us(4 * patience_us)};
    }
    costs.lock_moved = lock_moved_ns();
    costs.dispatch.moved = dispatch_ns(threads);
    if (threads == 2) costs.flag = {flag_seen_ns(), flag_read_ns()};
  });
  omp_set_num_threads(threads_before);
  for (int t = 1; t <= omp_get_num_procs(); t *= 2)
    costs.bytes_per_ns = std::max(costs.bytes_per_ns, triad_gb_per_s(t));
  return costs;
}

}  // namespace lockstep::verify
