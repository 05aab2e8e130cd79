// The dot product, in an order that lanes and threads can keep.
//
// The contract stands in common/linear/dot.h.
#include "common/linear/dot.h"

#include <algorithm>

#include "common/real.h"

namespace lockstep::linear::serial {
namespace {

// The sum of one block.
double block_sum(std::span<const Real> x, std::span<const Real> y) {
  double lane[dot_lanes] = {};
  for (std::size_t i = 0; i < x.size(); ++i)
    lane[i % dot_lanes] += static_cast<double>(x[i]) * static_cast<double>(y[i]);
  for (int half = dot_lanes / 2; half > 0; half /= 2)
    for (int l = 0; l < half; ++l) lane[l] += lane[l + half];
  return lane[0];
}

}  // namespace

double dot(std::span<const Real> x, std::span<const Real> y) {
  double sum = 0;
  for (std::size_t begin = 0; begin < x.size(); begin += dot_block) {
    const std::size_t count = std::min<std::size_t>(dot_block, x.size() - begin);
    sum += block_sum(x.subspan(begin, count), y.subspan(begin, count));
  }
  return sum;
}

}  // namespace lockstep::linear::serial
