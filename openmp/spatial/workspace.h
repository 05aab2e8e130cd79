// What broad phases work in, kept from call to call.
//
// A broad phase writes down some ten megabytes that no one needs afterwards. Fresh pages from the system cost a third of a run (10,000
// boxes, one thread), and the system hands them out to one thread at a time.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "common/array.h"
#include "common/spatial/pairs.h"

namespace lockstep::spatial::openmp {

// What radix_sort sorts.
struct Keyed {
  std::uint32_t key;
  std::int32_t element;
};

// Pairs that a thread finds without knowing how many.
struct PairList {
  int count = 0;
  Array<std::int32_t> a, b;  // sixteen may be stored behind the last
};

// Each is for the function of that name.
struct Workspace {
  struct {
    Array<Keyed> keyed, other;
  } radix_sort;
  std::vector<PairList> collect;
  PairList joined;
  Array<Pair> order_pairs;
};

// The calling thread's own; the threads that it forks work in it.
inline Workspace& workspace() {
  thread_local Workspace mine;
  return mine;
}

template <class T>
void grow(Array<T>& array, std::size_t n) {
  if (array.size() < n) array.resize(std::max(n, 2 * array.size()));
}

}  // namespace lockstep::spatial::openmp
