// Lists of pairs that threads find without knowing how many.
#pragma once

#include <algorithm>
#include <cstdint>
#include <mutex>
#include <utility>
#include <vector>

#include "common/simd.h"
#include "common/spatial/pairs.h"
#include "openmp/failure.h"
#include "openmp/share.h"
#include "openmp/spatial/workspace.h"

namespace lockstep::spatial::openmp {

// Doubles the room of a list. Threads make room one after another: what one has taken, the next does not find
// available. If there is no room, list.failure gets InputError or std::bad_alloc, and the list is emptied. Does not
// throw, because a loop that may be left by an exception keeps less in registers: finding took 1.3 times as long.
[[gnu::noinline]] inline void make_room(PairList& list) noexcept {
  static std::mutex one_at_a_time;
  list.failure->guard([&] {
    const std::lock_guard lock(one_at_a_time);
    const std::size_t room = std::max<std::size_t>(2 * list.b.size(), 64 * lanes);
    require_pairs_fit(static_cast<double>(room), static_cast<double>(list.b.size()));
    list.a.resize(room), list.b.resize(room);
  });
  if (list.failure->happened()) list.count = 0;
}

// Where the second elements of `more` pairs may be stored, and of sixteen behind them; null if there is no room. The
// first elements are not stored: the caller knows them.
LOCKSTEP_INLINE std::int32_t* room_for(PairList& list, int more) {
  while (list.count + more + lanes > static_cast<int>(list.b.size())) {
    make_room(list);
    if (list.failure->happened()) return nullptr;
  }
  return &list.b[list.count];
}

// Adds the pairs of the active lanes, without a branch a pair.
LOCKSTEP_INLINE void add(PairList& list, maskv mask, intv a, intv b) {
  if (list.count + lanes > static_cast<int>(list.b.size())) make_room(list);
  store(&list.a[list.count], compress(mask, a));
  store(&list.b[list.count], compress(mask, b));
  list.count += count(mask);
}

// Calls find(i, list) for every i < n, and returns what it adds to the lists, one list a thread; the next call
// overwrites them. Which thread finds a pair is left to chance: chunks of `chunk` go to whoever is free, because some
// have far more to do than others. Throws InputError or std::bad_alloc if the pairs do not fit the memory; find itself
// must not throw.
template <class Find>
const std::vector<PairList>& collect(int n, int chunk, const Find& find) {
  std::vector<PairList>& lists = workspace().collect;
  lists.resize(omp_get_max_threads());
  for (PairList& list : lists) list.count = 0;  // the team may be smaller than that of the last call
  lockstep::openmp::Failure failure;
#pragma omp parallel
  {
    // A thread adds to its own list alone; while it does, the list is where no other thread writes.
    PairList mine = std::move(lists[omp_get_thread_num()]);
    mine.failure = &failure;
    if (mine.b.empty()) make_room(mine);
#pragma omp for schedule(dynamic, chunk) nowait
    for (int i = 0; i < n; ++i)
      if (!failure.happened()) find(i, mine);
    lists[omp_get_thread_num()] = std::move(mine);
  }
  failure.rethrow();
  return lists;
}

// How many pairs all lists have; that may be more than an int holds.
inline double count_pairs(const std::vector<PairList>& lists) {
  double count = 0;
  for (const PairList& list : lists) count += list.count;
  return count;
}

// All lists in one, which the next call overwrites. Throws as order_pairs does.
inline const PairList& joined(const std::vector<PairList>& lists) {
  PairList& all = workspace().joined;
  const double count = count_pairs(lists);
  require_pairs_fit(count, static_cast<double>(all.b.size()));
  grow(all.a, static_cast<std::size_t>(count));
  grow(all.b, static_cast<std::size_t>(count));
  all.count = static_cast<int>(count);
  // Each list belongs to one thread, which writes behind the lists before it.
#pragma omp parallel for schedule(static)
  for (std::size_t l = 0; l < lists.size(); ++l) {
    int before = 0;
    for (std::size_t k = 0; k < l; ++k) before += lists[k].count;
    std::copy_n(lists[l].a.begin(), lists[l].count, all.a.begin() + before);
    std::copy_n(lists[l].b.begin(), lists[l].count, all.b.begin() + before);
  }
  return all;
}

}  // namespace lockstep::spatial::openmp
