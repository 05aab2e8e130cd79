// Constraints put into batches, in parallel: the batches of make_batches (common/batches.h), number by number.
//
// First fit goes through the constraints in order; yet a constraint only waits for the earlier ones at its two objects. So each knows how
// many those are, its rank at either object, and each object counts how many have joined a batch. When both counts are the ranks, it is
// this constraint's turn at both objects, and no other's until it raises the counts: no lock is needed, and whatever threads do, the
// batches are those of going in order.
//
// Which thread has which constraints decides how often one waits for another. Constraints near in the order, or in space, wait for each
// other. Parts of the order would have each thread wait for the last constraints of another's; a cut through space few constraints cross.
// A thread has those at objects between two planes across an axis, about as many as others, and takes them in order, but for those whose
// turn has not come. All threads go through some of theirs, in a round, before they look at what is left again: a thread that waited for
// another one by itself would keep a core busy that the other one may need.
//
// Source: greedy algorithms run along their dependences: Blelloch, Fineman and Shun, Greedy Sequential Maximal Independent Set and Matching
//         are Parallel on Average (SPAA 2012).
#pragma once

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "common/batches.h"
#include "openmp/share.h"

namespace lockstep::openmp {

inline constexpr std::int32_t immovable = -1;  // instead of an object that conflicts with nobody

// A constraint's objects, and how many constraints at each are before it.
struct RankedConstraint {
  std::int32_t a, b, rank_a, rank_b;
};

// What is known of an object. A cache line each, so that other threads' objects are not on it.
struct alignas(64) Occupied {
  static constexpr int words = 7;
  std::int32_t joined = 0;          // how many of its constraints are in a batch
  std::uint64_t taken[words] = {};  // which batches those are, one bit a batch
};
inline constexpr int most_batches = 64 * Occupied::words;

// First fit for the constraints of the calling thread, one of a team of which all call; returns how many batches they reach.
//
// rounds[thread]: how many rounds the thread needs, 0 as long as that is not known. In a round a thread goes once through the constraints
// in its view. An object is its own from when it sees that it is the turn of a constraint there, which the thread before has said after its
// last change to the object, until it says that it is the next one's.
inline int first_fit(std::span<const std::uint16_t> thread_of, std::span<const RankedConstraint> constraints, Occupied* object,
                     std::int32_t* batch_of, std::vector<std::atomic<int>>& rounds) {
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
  for (int round = 0; std::ranges::any_of(rounds, [&](int needed) { return needed == unknown || needed > round; }); ++round) {
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
    // All agree on whether there is another round: what a thread may write in that one does not change the answer. In every round one has
    // its turn at least, the first of all that are left.
    if (left == 0 && k == count && rounds[thread] == unknown) rounds[thread] = round + 1;
#pragma omp barrier
  }
  return batches;
}

// As make_batches, of constraints between two different objects each. place(i), a number, grows along the axis with the place of object i.
template <class Place>
Batches make_batches_in_parallel(std::span<const std::int32_t> a, std::span<const std::int32_t> b, std::span<const char> movable,
                                 const Place& place) {
  const int objects = static_cast<int>(movable.size()), constraints = static_cast<int>(a.size());
  const auto object = std::make_unique_for_overwrite<Occupied[]>(objects);
  const auto ranked = std::make_unique_for_overwrite<RankedConstraint[]>(constraints);
  std::vector<std::int32_t> batch_of(constraints);
  std::vector<std::uint16_t> thread_of(constraints), thread_of_object(objects);
  std::vector<decltype(place(0))> cuts;         // [thread]: where the objects of the next one begin
  std::vector<std::vector<std::int32_t>> next;  // [thread][object]: the rank there of the next constraint; then [thread][batch]
  std::vector<int> bound, reached;              // [thread]: batches, at the most and in fact
  std::vector<std::atomic<int>> rounds;         // [thread]
  Batches batches;
  batches.order.resize(constraints);
  batches.begin = {0};

  // Each thread writes the numbers of its own share, and counts of its own; barriers stand between one thread's writing and another's
  // reading.
#pragma omp parallel
  {
    const int me = omp_get_thread_num(), threads = omp_get_num_threads();
    const Share mine = my_share(constraints);
#pragma omp single
    {
      next.resize(threads), bound.resize(threads), reached.resize(threads);
      rounds = std::vector<std::atomic<int>>(threads);
      const int samples = std::min(objects, 16 * threads);
      std::vector<decltype(place(0))> sample(samples);
      for (int s = 0; s < samples; ++s) sample[s] = place(static_cast<int>(std::int64_t(s) * objects / samples));
      std::ranges::sort(sample);
      for (int thread = 1; thread < threads && samples > 0; ++thread) cuts.push_back(sample[samples * thread / threads]);
    }

    // Ranks. Each thread counts what its share, a part of the order, has at every object; every object is one thread's, which adds up what
    // comes before each share; every constraint is one thread's again.
    next[me].assign(objects, 0);
    std::int32_t* rank = next[me].data();
    for (int k = mine.begin; k < mine.end; ++k) ++rank[a[k]], ++rank[b[k]];
#pragma omp barrier
#pragma omp for schedule(static)
    for (int i = 0; i < objects; ++i) {
      for (int thread = 0, sum = 0; thread < threads; ++thread) sum += std::exchange(next[thread][i], sum);
      thread_of_object[i] = static_cast<std::uint16_t>(std::ranges::upper_bound(cuts, place(i)) - cuts.begin());
      object[i] = {};
    }
    int most = 0;
    for (int k = mine.begin; k < mine.end; ++k) {
      const auto ranked_at = [&](std::int32_t i) { return movable[i] ? std::pair(i, rank[i]++) : std::pair(immovable, 0); };
      const auto [at_a, rank_a] = ranked_at(a[k]);
      const auto [at_b, rank_b] = ranked_at(b[k]);
      ranked[k] = {at_a, at_b, rank_a, rank_b};
      thread_of[k] = thread_of_object[movable[a[k]] ? a[k] : b[k]];
      most = std::max(most, rank_a + rank_b + 1);
    }
    bound[me] = most;
#pragma omp barrier

    if (std::ranges::max(bound) <= most_batches) {
      reached[me] = first_fit(thread_of, {ranked.get(), a.size()}, object.get(), batch_of.data(), rounds);
#pragma omp barrier
      // The order of the batches, counted as the ranks are.
      const int count = std::ranges::max(reached);
      next[me].assign(count, 0);
      std::int32_t* to = next[me].data();
      for (int k = mine.begin; k < mine.end; ++k) ++to[batch_of[k]];
#pragma omp barrier
#pragma omp single
      for (int batch = 0, sum = 0; batch < count; ++batch) {
        for (std::vector<std::int32_t>& of_thread : next) sum += std::exchange(of_thread[batch], sum);
        batches.begin.push_back(sum);
      }
      for (int k = mine.begin; k < mine.end; ++k) batches.order[to[batch_of[k]]++] = k;
    }
  }
  // Where an object has that many constraints, each waits for the one before it.
  if (std::ranges::max(bound) > most_batches) return make_batches(a, b, movable);
  return batches;
}

}  // namespace lockstep::openmp
