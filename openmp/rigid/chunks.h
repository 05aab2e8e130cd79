// How many pairs a thread takes at once. Results do not depend on it: each pair has the same steps in any company.
#pragma once

#include <omp.h>

#include <algorithm>
#include <cstddef>

#include "common/simd.h"

namespace lockstep::rigid::openmp {

// Whole vectors, of `pairs` in all, and no more than `most`: three chunks a thread, so that one that ends early takes
// over from others; but two vectors at least, below which fetching a chunk and vectors that are not full cost more.
inline int chunk_of(std::size_t pairs, int most) {
  constexpr std::size_t chunks_a_thread = 3;
  const std::size_t even = pairs / (chunks_a_thread * omp_get_max_threads()) / lanes * lanes;
  return static_cast<int>(std::clamp<std::size_t>(even, 2 * lanes, most));
}

}  // namespace lockstep::rigid::openmp
