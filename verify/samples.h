// Which of the benchmark's samples count.
//
// Two virtual cores are not always two: for seconds on end both may be halves of one of the host's, or another guest has the other half.
// Two threads then gain 1.1 or 1.7 times one where they gain 1.95 else. So a loop over registers runs beside each sample and says how many
// cores' work the threads got done.
#pragma once

#include <cstddef>
#include <vector>

namespace lockstep::verify {

struct Sample {
  double seconds;
  double turns;  // a ns, of the loop over registers on all threads
};

struct Counted {
  std::vector<Sample> samples;
  bool lack_cores;
};

// Sets samples aside that had less than nine tenths of the cores: `whole` is what whole cores turn a ns. Where that leaves fewer than half
// of them, and fewer than `enough`, they lack cores, and all count.
Counted counted(const std::vector<Sample>& samples, double whole, std::size_t enough);

// q = 0: the least; .5: the median. There must be a sample.
double quantile(const std::vector<Sample>& samples, double Sample::*of, double q);

}  // namespace lockstep::verify
