// Work between two barriers: of one batch, which a team shares, or of several small batches in order, which one thread
// takes because a barrier would cost more.
#pragma once

#include <vector>

namespace lockstep::openmp {

struct Stage {
  int begin, end;
  bool small;
};

// Adds a batch; begin .. end - 1 is what the caller counts in, such as batches or vectors.
inline void add_batch(int begin, int end, bool small, std::vector<Stage>& stages) {
  if (small && !stages.empty() && stages.back().small)
    stages.back().end = end;
  else
    stages.push_back({begin, end, small});
}

}  // namespace lockstep::openmp
