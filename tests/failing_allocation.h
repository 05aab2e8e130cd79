// Kernels where memory runs out: whichever allocation fails, on whichever thread, the kernel must throw std::bad_alloc
// to its caller. (An exception that leaves a parallel region ends the program.)
#pragma once

#include <gtest/gtest.h>
#include <omp.h>

#include <atomic>
#include <functional>
#include <new>

namespace lockstep {

// So many allocations succeed, then one fails; negative: none fails. Read by the operator new of allocation_test.cpp.
extern std::atomic<long> succeed;

// Runs `work` on a copy of `start` with its first allocation failing, then its second, and so on until none is left to
// fail.
template <class State>
void every_allocation_may_fail(const State& start, const std::function<void(State&)>& work) {
  const int before = omp_get_max_threads();
  for (const int threads : {1, 3}) {
    omp_set_num_threads(threads);
    long allocations = 0;
    for (bool failed = true; failed; ++allocations) {
      State state = start;
      bool thrown = false;
      succeed = allocations;
      try {
        work(state);
      } catch (const std::bad_alloc&) {
        thrown = true;
      }
      failed = succeed.exchange(-1) < 0;
      ASSERT_EQ(thrown, failed) << "allocation " << allocations << ", " << threads << " threads";
    }
    EXPECT_GT(allocations, 1);
  }
  omp_set_num_threads(before);
}

}  // namespace lockstep
