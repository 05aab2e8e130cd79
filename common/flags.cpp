#include "common/flags.h"

#include <linux/futex.h>
#include <sched.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <chrono>
#include <climits>
#include <utility>

namespace lockstep {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

// As threads of a held team wait (verify/crew.cpp, notes/waiting.md): so many turns of a loop; then, for so long, the
// thread gives its core to others between looks; then it sleeps. A thread that gets its core back late shares it with
// another program that computes. It sleeps at once for a spell.
constexpr int turns = 50;
constexpr std::chrono::microseconds patience = 50us, late = 500us, spell = 1s;
thread_local Clock::time_point shared_until;

void futex(const std::atomic<int>& word, int operation, int value) {
  static_assert(sizeof word == 4);
  syscall(SYS_futex, &word, operation, value, nullptr, nullptr, 0);
}

}  // namespace

void lockstep_post(Flag* flag, int value) {
  flag->value.store(value);
  if (flag->sleepers.load() > 0) futex(flag->value, FUTEX_WAKE_PRIVATE, INT_MAX);
}

void lockstep_await(const Flag* flag, int value) {
  const auto has_come = [&] { return flag->value.load(std::memory_order_acquire) >= value; };
  for (int turn = 0; turn < turns; ++turn) {
    if (has_come()) return;
#if defined(__x86_64__)
    __builtin_ia32_pause();
#endif
  }
  const Clock::time_point start = Clock::now();
  for (Clock::time_point time = start; time >= shared_until && time < start + patience;) {
    if (has_come()) return;
    sched_yield();
    const Clock::time_point yielded = std::exchange(time, Clock::now());
    if (time - yielded > late) shared_until = time + spell;
  }
  // Whoever posts sees a sleeper, or the sleeper sees the value: the kernel compares before it puts a thread to sleep.
  flag->sleepers.fetch_add(1);
  for (int now; (now = flag->value.load()) < value;) futex(flag->value, FUTEX_WAIT_PRIVATE, now);
  flag->sleepers.fetch_sub(1);
}

}  // namespace lockstep
