// How a thread waits for another: it turns in a loop, then gives its core to others between looks, then sleeps
// (notes/waiting.md).
#pragma once

#include <atomic>
#include <chrono>

namespace lockstep {

// For how long a thread turns, at most, and then yields its core between looks before it sleeps.
inline constexpr int turning_us = 1, patience_us = 50;

// Tells the processor that this thread waits in a loop.
inline void pause() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#endif
}

// A number that threads wait for, and how many of them sleep until it changes.
struct Awaited {
  std::atomic<int> value = 0;
  mutable std::atomic<int> sleepers = 0;
};

// Wakes those that sleep. To be called after each change of the value.
void wake(const Awaited& awaited);

// For how long another program is expected to go on using a core that a waiting thread needs: 0 if none does.
std::chrono::steady_clock::duration cores_shared_for();

// A thread that yields between looks.
class Yielding {
 public:
  bool goes_on() const;  // false: the thread should sleep
  void yield();

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point start_ = Clock::now(), time_ = start_;
};

// Sleeps until the value is another than `before`. It may also wake without cause.
void sleep_while(const Awaited& awaited, int before);

// Waits until has_come(value) is true. The thread then sees what was written before the value was set.
template <class HasCome>
void wait(const Awaited& awaited, const HasCome& has_come) {
  // Most waits at a barrier are over after so many turns. They take turning_us at most.
  constexpr int turns = 20;
  const auto is_there = [&] { return has_come(awaited.value.load(std::memory_order_acquire)); };
  for (int turn = 0; turn < turns; ++turn) {
    if (is_there()) return;
    pause();
  }
  for (Yielding yielding; yielding.goes_on(); yielding.yield())
    if (is_there()) return;
  // Whoever sets the value sees a sleeper, or the sleeper sees the value: the kernel compares before it puts a thread
  // to sleep.
  awaited.sleepers.fetch_add(1);
  for (int now; !has_come(now = awaited.value.load());) sleep_while(awaited, now);
  awaited.sleepers.fetch_sub(1);
}

}  // namespace lockstep
