// Replays a record (record.h) on as many simulated cores as it was made for. Work takes its recorded time. Barriers,
// locks and loops impose the order, at their costs on this machine.
#pragma once

#include <cmath>

#include "common/waiting.h"
#include "verify/record.h"

namespace lockstep::verify {

// The cost of a joint operation of all threads, in ns, measured with one thread and with two. A tree of P leaves is
// log2 P deep, and each level costs as much as two threads pay.
struct Together {
  double one = 0, two = 0;
  double at(int cores) const { return cores == 1 ? one : two * std::log2(cores); }
};

// The cost of an exclusive operation, in ns: if this core did it last, and if another core did.
struct OneAtATime {
  double again = 0, moved = 0;
};

// A thread that has run out of patience falls asleep for so long, and wakes faster than later. On a virtual machine
// (Emerald Rapids) most waits of 55 us found it so, half of those of 60, and none of 75.
inline constexpr int falling_asleep_us = 10;

// What a long wait costs at a barrier, or for a region to begin or to end, in ns. A short one is spent in a loop, and
// what is left of it is part of Together. Later the thread yields between looks, then it falls asleep, and at last it
// sleeps (common/waiting.h).
struct Waking {
  // How late the thread goes on, and how late the one that it has waited for, which wakes it.
  struct Late {
    double waiting = 0, waker = 0;
  };
  double from_yielding = 0;
  Late falling_asleep, asleep;

  Late after(double waited_ns) const {
    if (waited_ns > 1e3 * (patience_us + falling_asleep_us)) return asleep;
    if (waited_ns > 1e3 * patience_us) return falling_asleep;
    return {waited_ns > 1e3 * turning_us ? from_yielding : 0, 0};
  }
};

// What a flag costs the core that awaits it.
struct Awaiting {
  double seen = 0;  // from the post until that core sees it
  double read = 0;  // to read one that was posted before
};

struct Costs {
  Together fork_join, barrier;
  Waking waking;
  double lock_moved = 0;  // extra cost of a lock that another core held last; the rest is in the record
  OneAtATime dispatch;    // to fetch a chunk of a loop
  Awaiting flag;
  double bytes_per_ns = 0;  // memory bandwidth of all cores together; no bound if 0
};

// How the time is spent, in ns. All but `total` and `compute` are sums over the cores.
struct Replayed {
  double total = 0;     // from beginning to end, on the clock
  double compute = 0;   // the same without the bound by memory
  double work = 0;      // the kernel's own work
  double serial = 0;    // idle while one core works outside regions
  double together = 0;  // forks, joins and barriers themselves
  double locks = 0;     // taking locks and waiting for them
  double dispatch = 0;  // fetching chunks and waiting for them
  double waiting = 0;   // waiting for the slowest core, at barriers and the ends of regions, and for flags
};

// `bytes` is the memory traffic of the work, 0 if caches hold the data. The total is at least the time of that traffic.
Replayed replay(const Record& record, const Costs& costs, double bytes);

}  // namespace lockstep::verify
