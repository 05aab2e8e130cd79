// Sums in blocks of a fixed size, so that they have the same bits at every number of threads: each block's sum is one
// thread's work, and the sums are added in the order of the blocks.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "common/linear/dot.h"
#include "common/simd.h"
#include "common/simd_double.h"

namespace lockstep::linear::openmp {

static_assert(dot_lanes == lanes && dot_block % lanes == 0);

// The products of sixteen elements, added to `sum`; inactive lanes hold zeros, and 0 added to a sum that began at 0
// changes no bit.
LOCKSTEP_INLINE doublev add_products(doublev sum, floatv x, floatv y) { return sum + to_double(x) * to_double(y); }

// The sum over all blocks of n elements; block(begin, end) returns that of elements begin .. end - 1.
template <class Block>
double sum_of_blocks(std::size_t n, const Block& block) {
  const std::ptrdiff_t blocks = (n + dot_block - 1) / dot_block;
  std::vector<double> sums(blocks);
  // A block writes its own sum, and what `block` writes lies within the block.
#pragma omp parallel for schedule(static)
  for (std::ptrdiff_t b = 0; b < blocks; ++b)
    sums[b] = block(b * dot_block, std::min<std::size_t>((b + 1) * dot_block, n));
  double sum = 0;
  for (const double s : sums) sum += s;
  return sum;
}

}  // namespace lockstep::linear::openmp
