// Constraints put into batches: those of common/batches.h, number by number.
//
// make_batches and make_folded_levels choose in sequence and order constraints in parallel. make_batches_in_parallel
// makes the choice in parallel, too. It is kept as a form to compare with: at the sizes of our scenes, a million
// constraints and fewer, it never pays (notes/batches.md). Memory, besides the result: 64 bytes an object, 4 bytes an
// object and thread, and 22 bytes a constraint.
//
// It has three phases: ranks, counted as in a radix sort; the choice of batches (openmp/first_fit.h); the order of
// constraints by batch, a counting sort.
//
// Which thread has which constraints decides how often threads wait. Constraints that are near in the order or in space
// depend on each other. Splitting by index would make each thread wait for the end of its predecessor's part. So
// objects are split into slabs along an axis with equal counts; few constraints cross a slab boundary. A thread goes
// through its constraints in order and skips those whose turn has not come. All threads work in rounds: a thread that
// spun for another one would keep a core busy that the other one may need.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "common/batches.h"
#include "openmp/counting_sort.h"
#include "openmp/first_fit.h"
#include "openmp/share.h"

namespace lockstep::openmp {

// As lockstep::in_batches.
inline Batches in_batches(std::span<const std::int32_t> batch_of, int count) {
  Batches batches;
  batches.order.resize(batch_of.size());
  batches.begin.resize(count + 1);
  CountingSort sort(count);
  // A thread moves its own share of the constraints to where the sort tells it.
#pragma omp parallel
  {
    const Share mine = my_share(static_cast<int>(batch_of.size()));
    sort(
        [&](const auto& visit) {
          for (int k = mine.begin; k < mine.end; ++k) visit(k, batch_of[k]);
        },
        [to = batches.order.data()](std::int32_t k, int place) { to[place] = k; }, batches.begin.data());
  }
  return batches;
}

// The calling thread's own, kept from call to call (openmp/spatial/workspace.h says why): n batches to write.
inline std::span<std::int32_t> own_batches(std::size_t n) {
  thread_local std::vector<std::int32_t> mine;
  if (mine.size() < n) mine.resize(n);
  return std::span(mine).first(n);
}

inline Batches make_batches(std::span<const std::int32_t> a, std::span<const std::int32_t> b,
                            std::span<const char> movable) {
  const std::span<std::int32_t> batch_of = own_batches(a.size());
  return in_batches(batch_of, choose_batches(a, b, movable, batch_of));
}

inline Batches make_folded_levels(std::span<const std::int32_t> a, std::span<const std::int32_t> b,
                                  std::span<const char> movable) {
  const std::span<std::int32_t> batch_of = own_batches(a.size());
  return in_batches(batch_of, choose_folded_levels(a, b, movable, batch_of));
}

// As make_batches, for constraints between two different objects each. place(i), a number, grows along the axis with
// the place of object i.
template <class Place>
Batches make_batches_in_parallel(std::span<const std::int32_t> a, std::span<const std::int32_t> b,
                                 std::span<const char> movable, const Place& place) {
  const int objects = static_cast<int>(movable.size()), constraints = static_cast<int>(a.size());
  const auto object = std::make_unique_for_overwrite<Occupied[]>(objects);
  const auto ranked = std::make_unique_for_overwrite<RankedConstraint[]>(constraints);
  std::vector<std::int32_t> batch_of(constraints);
  std::vector<std::uint16_t> thread_of(constraints), thread_of_object(objects);
  // The team may be smaller than most_threads. All memory is allocated here: an exception cannot leave the region.
  const int most_threads = omp_get_max_threads();
  std::vector<decltype(place(0))> sample, cuts;  // cuts[thread]: where the objects of the next one begin
  sample.reserve(16 * most_threads), cuts.reserve(most_threads);
  // [thread][object]: the rank there of the next constraint.
  std::vector<std::vector<std::int32_t>> next(most_threads, std::vector<std::int32_t>(objects));
  std::vector<int> bound(most_threads), reached(most_threads);  // [thread]: batches, at the most and in fact
  std::vector<std::atomic<int>> rounds(most_threads);

  // Each thread writes the numbers and counts of its own share. Barriers stand between one thread's writing and
  // another's reading.
#pragma omp parallel
  {
    const int me = omp_get_thread_num(), threads = omp_get_num_threads();
    const Share mine = my_share(constraints);
#pragma omp single
    {
      const int samples = std::min(objects, 16 * threads);
      for (int s = 0; s < samples; ++s) sample.push_back(place(static_cast<int>(std::int64_t(s) * objects / samples)));
      std::ranges::sort(sample);
      for (int thread = 1; thread < threads && samples > 0; ++thread)
        cuts.push_back(sample[samples * thread / threads]);
    }

    // Ranks. Each thread counts, at every object, the constraints of its own share of the order. Then each object has
    // one thread, which adds up the counts of the shares before each share. Then each constraint has one thread again.
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
      const auto ranked_at = [&](std::int32_t i) {
        return movable[i] ? std::pair(i, rank[i]++) : std::pair(immovable, 0);
      };
      const auto [at_a, rank_a] = ranked_at(a[k]);
      const auto [at_b, rank_b] = ranked_at(b[k]);
      ranked[k] = {at_a, at_b, rank_a, rank_b};
      thread_of[k] = thread_of_object[movable[a[k]] ? a[k] : b[k]];
      most = std::max(most, rank_a + rank_b + 1);
    }
    bound[me] = most;
#pragma omp barrier

    if (std::ranges::max(bound) <= most_batches)
      reached[me] = first_fit(thread_of, {ranked.get(), a.size()}, object.get(), batch_of.data(),
                              {rounds.data(), std::size_t(threads)});
  }
  // An object has too many constraints. Each of them waits for the one before it, so little is parallel.
  if (std::ranges::max(bound) > most_batches) return make_batches(a, b, movable);
  return in_batches(batch_of, std::ranges::max(reached));
}

}  // namespace lockstep::openmp
