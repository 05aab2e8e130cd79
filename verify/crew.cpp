#include "verify/crew.h"

#include <linux/futex.h>
#include <omp.h>
#include <sched.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <climits>
#include <utility>

#include "verify/pause.h"
#include "verify/team.h"

namespace lockstep::verify {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

// A wait begins with so many turns of a loop: most waits at a barrier are over then. They take turning_us at most.
constexpr int turns = 20;
// Then, for so long, the thread gives its core to others between looks, and sleeps after that. To sleep and wake costs
// 5 to 50 microseconds.
constexpr std::chrono::microseconds patience{patience_us};
// A thread that gets its core back so late has shared it with another program that computes. It lost a slice of the
// scheduler's time, 3 ms here. So it sleeps at once for a spell. What took the core may be gone after it, or have been
// the host of a virtual machine: the first spell is short. Each that is followed by another soon is twice as long.
constexpr auto late = 500us;
constexpr Clock::duration shortest_spell = 5ms, longest_spell = 1s;
// When the last spell of any thread ends. Of two threads that set it at once, either will do.
std::atomic<Clock::time_point> last_spell_ends = Clock::time_point();

long futex(const std::atomic<unsigned>& word, int operation, unsigned value) {
  static_assert(sizeof word == 4);
  return syscall(SYS_futex, &word, operation, value, nullptr, nullptr, 0);
}

}  // namespace

void Crew::Gate::open() {
  opened_.fetch_add(1);
  if (sleepers_.load() > 0) futex(opened_, FUTEX_WAKE_PRIVATE, INT_MAX);
}

void Crew::Gate::wait(unsigned before) {
  thread_local Clock::time_point shared_until;
  thread_local Clock::duration spell = 0ms;
  for (int turn = 0; turn < turns; ++turn) {
    if (opened_.load(std::memory_order_acquire) != before) return;
    pause();
  }
  const Clock::time_point start = Clock::now();
  for (Clock::time_point time = start; time >= shared_until && time < start + patience;) {
    if (opened_.load(std::memory_order_acquire) != before) return;
    sched_yield();
    const Clock::time_point yielded = std::exchange(time, Clock::now());
    if (time - yielded > late) {
      spell = time < shared_until + 2 * spell ? std::min(2 * spell, longest_spell) : shortest_spell;
      shared_until = time + spell;
      if (shared_until > last_spell_ends.load()) last_spell_ends = shared_until;
    }
  }
  // Whoever opens sees a sleeper, or the sleeper sees that it has been opened: the kernel compares before it puts a
  // thread to sleep.
  sleepers_.fetch_add(1);
  while (opened_.load() == before) futex(opened_, FUTEX_WAIT_PRIVATE, before);
  sleepers_.fetch_sub(1);
}

Clock::duration Crew::cores_shared_for() {
  return std::max<Clock::duration>(last_spell_ends.load() - Clock::now(), 0s);
}

void Crew::run() {
  in_region_ = true;
  region_(data_);
  in_region_ = false;
  omp_set_num_threads(asked_for_);  // a region may have set another number for the regions that it opens
}

void Crew::parallel(void (*region)(void*), void* data) {
  note_team_size(size_);
  region_ = region, data_ = data;
  running_.store(size_ - 1);
  const unsigned ended = end_.opened();
  begin_.open();
  run();
  if (size_ > 1) end_.wait(ended);
}

void Crew::serve() {
  for (unsigned begun = 0;; ++begun) {
    begin_.wait(begun);
    if (!region_) return;
    run();
    if (running_.fetch_sub(1) == 1) end_.open();
  }
}

void Crew::dismiss() {
  region_ = nullptr;
  begin_.open();
}

void Crew::barrier() {
  const unsigned before = all_arrived_.opened();
  if (arrived_.fetch_add(1) + 1 < size_) return all_arrived_.wait(before);
  arrived_.store(0);
  all_arrived_.open();
}

}  // namespace lockstep::verify
