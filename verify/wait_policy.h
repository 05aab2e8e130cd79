// How OpenMP's threads wait for each other.
#pragma once

#include <string>

namespace lockstep::verify {

// Starts the program again with GOMP_SPINCOUNT set, unless the user has set it or OMP_WAIT_POLICY: libgomp reads both
// once, before main. Call it first. By default libgomp's threads spin 300,000 turns at a barrier before they sleep.
// Where another program has the core of the thread that they wait for, they spin through its whole time slice:
// hundreds of times slower than one thread. notes/waiting.md has the measurements. Returns if the program could not be
// started again.
void wait_calmly(char** argv);

}  // namespace lockstep::verify
