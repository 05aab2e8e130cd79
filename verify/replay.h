// Replays a record (record.h) on as many simulated cores as it was made for: the work as it was timed, in the order that barriers, locks
// and loops impose, at what those cost on this machine.
#pragma once

#include <cmath>

#include "verify/record.h"

namespace lockstep::verify {

// What all threads of a team do together, in ns. Measured with one thread and with two; a tree of P leaves is log2 P deep, and each
// level costs what two threads pay.
struct Together {
  double one = 0, two = 0;
  double at(int cores) const { return cores == 1 ? one : two * std::log2(cores); }
};

// What one thread at a time may do, in ns: where this core did it last, and where another did.
struct OneAtATime {
  double again = 0, moved = 0;
};

struct Costs {
  Together fork_join, barrier;
  double lock_moved = 0;    // to have a lock that another core had last, beyond what one's own costs, which is in the record
  OneAtATime dispatch;      // to fetch a chunk of a loop
  double bytes_per_ns = 0;  // of memory, by all cores together; no bound where 0
};

// Where the time went, in ns; but for `total` and `compute` the sum over the cores.
struct Replayed {
  double total = 0;     // from beginning to end, on the clock
  double compute = 0;   // the same, were memory no bound
  double work = 0;      // at the kernel's own work
  double serial = 0;    // idle while one core works outside regions
  double together = 0;  // in forks, joins and barriers themselves
  double locks = 0;     // to take locks and wait for them
  double dispatch = 0;  // to fetch chunks and wait for them
  double waiting = 0;   // for the slowest, at barriers and the ends of regions
};

// `bytes` must come from and go to memory: the record takes no less time than that does. 0 where caches hold them.
Replayed replay(const Record& record, const Costs& costs, double bytes);

}  // namespace lockstep::verify
