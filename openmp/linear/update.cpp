// The vector updates of conjugate gradients, sixteen elements at a time; `descend` sums r . r while r is at hand.
//
// The contract stands in common/linear/update.h.
#include "common/linear/update.h"

#include <cstddef>

#include "openmp/linear/block_sums.h"
#include "openmp/whole_vectors.h"

namespace lockstep::linear::openmp {
namespace {

using lockstep::openmp::Whole;
using lockstep::openmp::with_first_lanes;

// Calls update(i, mask) for each sixteen elements of n; of those that are whole, with Whole in place of a mask.
template <class Update>
void for_sixteens(std::size_t n, const Update& update) {
  const std::ptrdiff_t whole = n / lanes * lanes;
  // An element is read and written by its own iteration alone.
#pragma omp parallel for schedule(static)
  for (std::ptrdiff_t i = 0; i < whole; i += lanes) update(i, Whole());
  if (whole < static_cast<std::ptrdiff_t>(n)) update(whole, first_lanes(static_cast<int>(n - whole)));
}

}  // namespace

void axpy(float a, std::span<const float> x, std::span<float> y) {
  for_sixteens(y.size(), [&](std::size_t i, auto in) { store(&y[i], load(&y[i], in) + a * load(&x[i], in), in); });
}

void advance(float a, std::span<const float> z, float b, std::span<float> x, std::span<float> p) {
  for_sixteens(p.size(), [&](std::size_t i, auto in) {
    const floatv along = load(&p[i], in);
    store(&x[i], load(&x[i], in) + a * along, in);
    store(&p[i], load(&z[i], in) + b * along, in);
  });
}

double descend(float a, std::span<const float> q, std::span<float> r) {
  return sum_of_blocks(r.size(), [&](std::size_t begin, std::size_t end) {
    doublev sum = 0.;
    for (std::size_t i = begin; i < end; i += lanes)
      with_first_lanes(end - i, [&](auto in) {
        const floatv rest = load(&r[i], in) - a * load(&q[i], in);
        store(&r[i], rest, in);
        sum = add_products(sum, rest, rest);
      });
    return reduce_add(sum);
  });
}

}  // namespace lockstep::linear::openmp
