// Scratch memory of the sorts and pair lists, kept from call to call.
//
// Finding pairs writes some ten megabytes that nobody needs afterwards. Fresh pages from the system cost a third of a
// run (10,000 boxes, one thread), and the system hands them out to one thread at a time.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "common/array.h"
#include "common/spatial/pairs.h"
#include "openmp/failure.h"

namespace lockstep::spatial::openmp {

// What radix_sort sorts.
struct Keyed {
  std::uint32_t key;
  std::int32_t element;
};

// Pairs that a thread finds without knowing how many (pair_list.h). Sixteen may be stored behind the last.
struct PairList {
  int count = 0;
  Array<std::int32_t> a, b;
  lockstep::openmp::Failure* failure = nullptr;  // of who collects: gets the exception if there is no room
};

// Each member is for the function of that name.
struct Workspace {
  struct {
    Array<Keyed> keyed, other;
  } radix_sort;
  std::vector<PairList> collect;
  PairList joined;
  Array<Pair> order_pairs;
};

// The calling thread's own; a team works in that of the thread that forked it.
inline Workspace& workspace() {
  thread_local Workspace mine;
  return mine;
}

// Makes room for n elements at least.
template <class T>
void grow(Array<T>& array, std::size_t n) {
  if (array.size() < n) array.resize(std::max(n, 2 * array.size()));
}

}  // namespace lockstep::spatial::openmp
