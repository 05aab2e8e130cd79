// OpenMP programs that spend time on a simulated clock.
#pragma once

#include <functional>

#include "verify/record.h"
#include "verify/replay.h"

namespace lockstep::verify {

inline volatile double time_ns =
    0;  // volatile: the compiler assumes that a call of OpenMP's runtime does not change it
inline double test_clock() { return time_ns; }
inline void spend(double ns) { time_ns = time_ns + ns; }

inline const Costs free_of_charge = {};

// The time that the model gives to the work, ns.
inline double modelled(int cores, const std::function<void()>& work, const Costs& costs = free_of_charge,
                       double bytes = 0) {
  return replay(record(cores, work, test_clock, 0, Waits::noted), costs, bytes).total;
}

}  // namespace lockstep::verify
