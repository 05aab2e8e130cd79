// The threads of a held team (held_team.h), and how they wait. It answers the calls to OpenMP's runtime with which
// kernels fork, join and wait (record_wraps.cpp). Loops, sections and singles are still shared out by libgomp, for
// which the regions are one long region.
#pragma once

#include <atomic>
#include <utility>

#include "common/waiting.h"

namespace lockstep::verify {

class Crew {
 public:
  // `threads` serve the regions, and omp_get_max_threads() is `asked_for` in all of them. To be called before the other
  // functions, by one thread.
  void set_size(int threads, int asked_for) { size_ = threads, asked_for_ = asked_for; }
  int size() const { return size_; }

  // Runs a region on all threads, and returns when all have run it. Called by thread 0, outside regions.
  void parallel(void (*region)(void*), void* data);

  // Waits until all threads of the region have arrived.
  void barrier();

  // Whether the calling thread is in a region, and in no region inside it.
  static bool in_region() { return in_region_; }

  // Runs a region with one thread: for libgomp, all regions are inside the one in which the team is held.
  template <class Open>
  static void alone(Open open) {
    const bool was_in_region = std::exchange(in_region_, false);
    open();
    in_region_ = was_in_region;
  }

  // While the crew rests, thread 0 runs each region alone.
  void set_resting(bool resting) { resting_ = resting; }
  bool resting() const { return resting_; }

  // Runs regions until the crew is dismissed. Called by the other threads.
  void serve();
  void dismiss();

 private:
  // Something that threads wait for: each opening adds one.
  class Gate {
   public:
    int opened() const { return opened_.value.load(); }
    void open();
    void wait(int before);  // until opened() is another than `before`

   private:
    Awaited opened_;
  };
  void run();

  int size_ = 1, asked_for_ = 1;
  bool resting_ = false;
  // The gate of a region's beginning, and what the region is: on one cache line, which a thread fetches once.
  alignas(64) Gate begin_;
  void (*region_)(void*) = nullptr;  // the region to run; null: the crew is dismissed
  void* data_ = nullptr;
  alignas(64) Gate all_arrived_;
  alignas(64) Gate end_;
  alignas(64) std::atomic<int> arrived_ = 0;  // threads that wait at the barrier
  alignas(64) std::atomic<int> running_ = 0;  // threads that have not ended the region
  static inline thread_local bool in_region_ = false;
};

inline Crew* crew = nullptr;  // the one in use while a team is held

}  // namespace lockstep::verify
