// Measures what OpenMP and memory cost on this machine.
#pragma once

#include "verify/replay.h"

namespace lockstep::verify {

double triad_gb_per_s(int threads);   // a = b + 3 c over arrays beyond the caches, 12 bytes an element
double fma_gflop_per_s(int threads);  // independent fused multiply-adds in lanes, 2 flops each

// Iterations per ns, summed over all threads, of a loop that compares registers of lanes and does not touch memory.
// Measured now, in a tenth of a millisecond. Threads share nothing but cores. So if n threads make fewer than n times
// the best count of one thread, the machine does not give each thread a core of its own.
double turns_per_ns(int threads);

double last_level_cache();  // bytes

// Wakes all of OpenMP's threads. In the middle of a step they are awake, but a thread that was idle for long sleeps and
// takes about 50 us to wake.
void wake_team();

Costs measure_costs();

double clock_ns();       // the current time in ns
double clock_cost_ns();  // the cost of reading it

}  // namespace lockstep::verify
