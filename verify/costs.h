// What OpenMP and memory cost on this machine, measured.
#pragma once

#include "verify/replay.h"

namespace lockstep::verify {

double triad_gb_per_s(int threads);   // a = b + 3 c over arrays beyond the caches, 12 bytes an element
double fma_gflop_per_s(int threads);  // independent fused multiply-adds in lanes, 2 flops each

// Turns a ns that threads make in all of a loop that compares registers of lanes and touches no memory: now, in a tenth of a
// millisecond. Threads share nothing but cores, so where they make less than so many times what one makes at its best, the machine does not
// give a core to each.
double turns_per_ns(int threads);

double last_level_cache();  // bytes

// Has all of OpenMP's threads awake, as they are in the midst of a step: a thread that has long had nothing to do sleeps, and takes some
// 50 us to wake.
void wake_team();

Costs measure_costs();

double clock_ns();       // the time, in ns
double clock_cost_ns();  // of reading it

}  // namespace lockstep::verify
