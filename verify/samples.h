// Selects the benchmark's samples that were taken on whole cores.
//
// Two virtual cores are not always two real ones. For seconds at a time both may be halves of one core of the host, or
// another guest may use the other half. Two threads are then 1.1 or 1.7 times as fast as one, instead of 1.95 times. So
// a loop over registers runs beside each sample and measures how many cores' work the threads did.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

namespace lockstep::verify {

struct Sample {
  double seconds;
  double turns;  // iterations per ns of the loop over registers, on all threads
};

struct Counted {
  std::vector<Sample> samples;
  bool lack_cores;
};

// Drops the samples that had less than nine tenths of the cores. `whole` is the number of turns per ns on whole cores.
// If fewer than half of the samples remain, and fewer than `enough`, then `lack_cores` is set and all samples count.
Counted counted(const std::vector<Sample>& samples, double whole, std::size_t enough);

// q = 0: the least; .5: the median. `samples` must not be empty.
double quantile(const std::vector<Sample>& samples, double Sample::*of, double q);

// The interquartile range of the times over their median. A single sample has none.
std::optional<double> spread(const std::vector<Sample>& samples);

}  // namespace lockstep::verify
