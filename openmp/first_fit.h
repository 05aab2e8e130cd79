// First fit in parallel: each constraint of a ranked list joins the earliest batch that no earlier constraint at its
// objects is in.
//
// A constraint waits only for the earlier ones at its two objects. It knows how many those are: its rank at either
// object. Each object counts how many of its constraints have joined a batch. When both counts equal the ranks, this
// constraint has its turn at both objects. No other constraint has a turn there until it raises the counts. So no lock
// is needed, and the batches are those of serial order for any timing of the threads.
//
// Source: greedy algorithms run along their dependences: Blelloch, Fineman and Shun, Greedy Sequential Maximal
//         Independent Set and Matching are Parallel on Average (SPAA 2012).
#pragma once

#include <omp.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstdint>
#include <span>
#include <utility>

namespace lockstep::openmp {

inline constexpr std::int32_t immovable = -1;  // instead of an object that conflicts with nobody

// A constraint's objects, and how many constraints at each are before it.
struct RankedConstraint {
  std::int32_t a, b, rank_a, rank_b;
};

// The state of an object. Each has a cache line of its own, so that threads do not share lines.
struct alignas(64) Occupied {
  static constexpr int words = 7;
  std::int32_t joined = 0;          // how many of its constraints are in a batch
  std::uint64_t taken[words] = {};  // which batches those are, one bit a batch
};
inline constexpr int most_batches = 64 * Occupied::words;

// First fit for the constraints of the calling thread; all threads of a team call it. Returns how many batches they
// reach.
//
// rounds[thread]: how many rounds the thread needs, 0 while that is not known. In a round a thread goes once through
// the constraints in its window. A thread owns object i while joined[i] equals the rank there of one of its
// constraints. Reading that value with acquire makes the previous owner's writes visible; storing rank + 1 with release
// hands the object on.
inline int first_fit(std::span<const std::uint16_t> thread_of, std::span<const RankedConstraint> constraints,
                     Occupied* object, std::int32_t* batch_of, std::span<std::atomic<int>> rounds) {
  const auto has_turn = [=](std::int32_t i, std::int32_t rank) {
    return i == immovable || std::atomic_ref(object[i].joined).load(std::memory_order_acquire) == rank;
  };
  const auto join = [=](std::int32_t i, std::int32_t rank, int batch) {
    if (i == immovable) return;
    object[i].taken[batch / 64] |= std::uint64_t(1) << batch % 64;
    std::atomic_ref(object[i].joined).store(rank + 1, std::memory_order_release);
  };
  constexpr int window = 128, unknown = 0;
  std::int32_t in_view[window];
  const int thread = omp_get_thread_num(), count = static_cast<int>(constraints.size());
  int k = 0, left = 0, batches = 0;
  for (int round = 0; std::ranges::any_of(rounds, [&](int needed) { return needed == unknown || needed > round; });
       ++round) {
    for (; k < count && left < window; ++k)
      if (thread_of[k] == thread) in_view[left++] = k;
    const int seen = std::exchange(left, 0);
    for (int v = 0; v < seen; ++v) {
      const auto [a, b, rank_a, rank_b] = constraints[in_view[v]];
      if (!has_turn(a, rank_a) || !has_turn(b, rank_b)) {
        in_view[left++] = in_view[v];
        continue;
      }
      int word = 0;
      const auto in_use = [&](std::int32_t i) { return i == immovable ? 0 : object[i].taken[word]; };
      while (~(in_use(a) | in_use(b)) == 0) ++word;
      const int batch = 64 * word + std::countr_one(in_use(a) | in_use(b));
      join(a, rank_a, batch), join(b, rank_b, batch);
      batch_of[in_view[v]] = batch;
      batches = std::max(batches, batch + 1);
    }
    // All threads agree on whether there is another round, because what a thread may write in that round does not
    // change the answer. At least one constraint has its turn in every round: the first of all that are left.
    if (left == 0 && k == count && rounds[thread] == unknown) rounds[thread] = round + 1;
#pragma omp barrier
  }
  return batches;
}

}  // namespace lockstep::openmp
