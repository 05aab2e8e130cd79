// Lists of pairs that threads find without knowing how many.
#pragma once

#include <utility>

#include "common/simd.h"
#include "openmp/spatial/workspace.h"
#include "openmp/share.h"

namespace lockstep::spatial::openmp {

// Adds the pairs of the active lanes, without a branch a pair.
LOCKSTEP_INLINE void add(PairList& list, maskv mask, intv a, intv b) {
  if (list.count + lanes > static_cast<int>(list.a.size())) {
    grow(list.a, list.count + 64 * lanes);
    grow(list.b, list.count + 64 * lanes);
  }
  store(&list.a[list.count], compress(mask, a));
  store(&list.b[list.count], compress(mask, b));
  list.count += count(mask);
}

// Calls find(i, list) for every i < n: what it adds to the list comes back, a list a thread. Who finds what is left to chance: chunks of
// `chunk` go to whoever is free, as some have far more to do than others.
template <class Find>
const std::vector<PairList>& collect(int n, int chunk, const Find& find) {
  std::vector<PairList>& lists = workspace().collect;
  lists.resize(omp_get_max_threads());
#pragma omp parallel
  {
    // A thread adds to its own list alone; while it does, the list is where no other thread writes.
    PairList mine = std::move(lists[omp_get_thread_num()]);
    mine.count = 0;
#pragma omp for schedule(dynamic, chunk) nowait
    for (int i = 0; i < n; ++i) find(i, mine);
    lists[omp_get_thread_num()] = std::move(mine);
  }
  return lists;
}

// All in one.
inline const PairList& joined(const std::vector<PairList>& lists) {
  PairList& all = workspace().joined;
  all.count = 0;
  for (const PairList& list : lists) {
    grow(all.a, all.count + list.count);
    grow(all.b, all.count + list.count);
    std::copy_n(list.a.begin(), list.count, all.a.begin() + all.count);
    std::copy_n(list.b.begin(), list.count, all.b.begin() + all.count);
    all.count += list.count;
  }
  return all;
}

}  // namespace lockstep::spatial::openmp
