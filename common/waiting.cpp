#include "common/waiting.h"

#include <linux/futex.h>
#include <sched.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <climits>
#include <utility>

namespace lockstep {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

// To sleep and wake costs 5 to 50 microseconds.
constexpr std::chrono::microseconds patience{patience_us};
// A thread that gets its core back so late has shared it with another program that computes. It lost a slice of the
// scheduler's time, 3 ms here. So it sleeps at once for a spell. What took the core may be gone after it, or have been
// the host of a virtual machine: the first spell is short. Each that is followed by another soon is twice as long.
constexpr auto late = 500us;
constexpr Clock::duration shortest_spell = 5ms, longest_spell = 1s;
thread_local Clock::time_point shared_until;
thread_local Clock::duration spell = 0ms;
// When the last spell of any thread ends. Of two threads that set it at once, either will do.
std::atomic<Clock::time_point> last_spell_ends = Clock::time_point();

void futex(const std::atomic<int>& word, int operation, int value) {
  static_assert(sizeof word == 4);
  syscall(SYS_futex, &word, operation, value, nullptr, nullptr, 0);
}

}  // namespace

void wake(const Awaited& awaited) {
  if (awaited.sleepers.load() > 0) futex(awaited.value, FUTEX_WAKE_PRIVATE, INT_MAX);
}

void sleep_while(const Awaited& awaited, int before) { futex(awaited.value, FUTEX_WAIT_PRIVATE, before); }

Clock::duration cores_shared_for() { return std::max<Clock::duration>(last_spell_ends.load() - Clock::now(), 0s); }

bool Yielding::goes_on() const { return time_ >= shared_until && time_ < start_ + patience; }

void Yielding::yield() {
  sched_yield();
  const Clock::time_point yielded = std::exchange(time_, Clock::now());
  if (time_ - yielded <= late) return;
  spell = time_ < shared_until + 2 * spell ? std::min(2 * spell, longest_spell) : shortest_spell;
  shared_until = time_ + spell;
  if (shared_until > last_spell_ends.load()) last_spell_ends = shared_until;
}

}  // namespace lockstep
