// Carries an exception out of a parallel region. An exception that leaves the region by itself ends the program.
//
//   Failure failure;
//   #pragma omp parallel
//   {
//     failure.guard([&] { ...may throw, such as std::bad_alloc... });
//     #pragma omp barrier
//     if (!failure.happened()) ...what needs the above of all threads...
//   }
//   failure.rethrow();
#pragma once

#include <atomic>
#include <exception>
#include <utility>

namespace lockstep::openmp {

class Failure {
 public:
  // Runs `work`, and keeps what it throws. The first exception of all threads is kept; the others are dropped.
  template <class Work>
  void guard(const Work& work) noexcept {
    try {
      work();
    } catch (...) {
      if (!happened_.exchange(true, std::memory_order_acq_rel)) first_ = std::current_exception();
    }
  }

  // Whether any guarded work has thrown. All threads get the same answer behind a barrier that follows the guarded
  // work.
  bool happened() const { return happened_.load(std::memory_order_acquire); }

  // Throws the kept exception, if there is one. Call it outside the region, whose end makes the exception visible here.
  void rethrow() {
    if (happened_.exchange(false)) std::rethrow_exception(std::exchange(first_, nullptr));
  }

 private:
  std::atomic<bool> happened_ = false;
  std::exception_ptr first_;
};

}  // namespace lockstep::openmp
