// Records what each thread of a team of any size does in a kernel's parallel regions. The members run one at a time.
//
// The kernel runs unchanged. A simulated team answers its calls to the OpenMP runtime (record_wraps.cpp, recorder.h).
// Each member runs the region on its own stack until it meets a barrier or asks for a chunk of a loop. Then the member
// that has worked least so far goes on. Members are spread over the machine's cores; one core works while the others
// wait. So:
//
//   - a kernel that divides its work by omp_get_num_threads() divides it for that many cores,
//   - chunks of dynamic loops go to the member that would be free first,
//   - data that other members wrote comes from another core's cache,
//   - the results are those of a real run.
//
// Two effects are lost: no two members access memory at once, and members share the caches of the existing cores
// (notes/scaling.md).
#pragma once

#include <functional>
#include <vector>

namespace lockstep::verify {

struct Event {
  enum Kind { work, lock, unlock, dispatch, single, barrier, post, await } kind;
  double ns = 0;               // work: its duration
  const void* what = nullptr;  // lock, unlock: the lock; post, await: the flag
  int value = 0;               // dispatch: the loop; single: whether this thread executes it; post, await: of the flag
};
using Events = std::vector<Event>;

// A region ends with its last thread. Chunks of dynamic loops belong to whoever fetches them: a thread that meets
// `dispatch` goes on with the next chunk of that loop until none is left.
struct Region {
  std::vector<Events> members;              // [thread]: its own, in order
  std::vector<std::vector<Events>> chunks;  // [loop][chunk]; a list of sections and a single count as loops
};

// Calls f(events) for each thread's own, then for each chunk's.
template <class R, class F>
void for_each_list(R& region, const F& f) {
  for (auto& events : region.members) f(events);
  for (auto& loop : region.chunks)
    for (auto& events : loop) f(events);
}

struct Record {
  int cores;
  std::vector<Region> regions;
  std::vector<double> serial_ns;  // before each region, and after the last
};

// Runs `work` once. `clock` gives the time in ns. `clock_ns` is the cost of reading it, which is subtracted from every
// stretch of work. `work` sees `cores` as omp_get_max_threads(). Nested regions have one thread, as by default in
// OpenMP. Not thread-safe. Locks are always taken, without contention; the cost of that counts as work. Flags are
// always posted, and a member that awaits one goes on when it is there.
enum class Waits { noted, left_out };  // for locks and for flags
Record record(int cores, const std::function<void()>& work, double (*clock)(), double clock_ns, Waits waits);

bool has_waits(const Record& record);

// Scales what each thread and each chunk of `noted` works to what it works in `whole`, a record of the same work with
// Waits::left_out. Reading the clock at each of a million locks takes time that cannot be separated from the kernel's
// own, because the processor overlaps the two; and at a flag, a member gives its turn away and goes on with an empty
// pipeline. So `noted` says how the work is spread over locks and flags, and `whole` says how much work there is.
void fit(Record& noted, const Record& whole);

// Several records of the same work. Other work on the machine only adds time, here to one stretch and there to another;
// on many cores, each of which has few stretches, one that was disturbed holds up all. So each stretch takes the least
// of its times. That says how the work is spread. How much there is in all says the record with the least work: also
// where threads that race divide their work differently each time, none is lost.
class Records {
 public:
  void add(Record record);
  Record least() const;  // of at least one

 private:
  Record spread_;
  double work_ns_ = 0;
};

}  // namespace lockstep::verify
