// The dot product, in an order that lanes and threads can keep: sixteen lanes of double a block, blocks shared among
// threads.
//
// The contract stands in common/linear/dot.h.
#include "common/linear/dot.h"

#include "openmp/linear/block_sums.h"

namespace lockstep::linear::openmp {

double dot(std::span<const float> x, std::span<const float> y) {
  return sum_of_blocks(x.size(), [&](std::size_t begin, std::size_t end) {
    doublev sum = 0.;
    std::size_t i = begin;
    for (; i + lanes <= end; i += lanes) sum = add_products(sum, load(&x[i]), load(&y[i]));
    if (i < end) {
      const maskv rest = first_lanes(static_cast<int>(end - i));
      sum = add_products(sum, load(&x[i], rest), load(&y[i], rest));
    }
    return reduce_add(sum);
  });
}

}  // namespace lockstep::linear::openmp
