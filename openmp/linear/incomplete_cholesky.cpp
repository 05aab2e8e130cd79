// The incomplete Cholesky factor and its solve, level by level: rows of a level do not wait for one another, so threads
// share them, and lanes take sixteen at once. Every row finds what it finds in order, so the bits are the serial ones.
//
// Levels begin with a barrier each, 382 on a grid of 128^3 points. The matrix is numbered by levels, so what a level
// reads and writes is near what the level before wrote, and columns of a slice mostly stand side by side
// (common/linear/sliced.h).
//
// The contract stands in common/linear/incomplete_cholesky.h.
#include "common/linear/incomplete_cholesky.h"

#include "common/linear/eliminate.h"
#include "common/real.h"
#include "openmp/linear/slots.h"

namespace lockstep::linear::openmp {

Factor<Real> incomplete_cholesky(const Rows<Real>& a, const Levels& levels, Modification modification) {
  Factor<Real> factor = make_factor(a);
#pragma omp parallel
  for (int level = 0; level < levels.count(); ++level) {
    // A row writes its own values, and reads those of rows of levels before, which the barrier at the end of the loop
    // has ended.
#pragma omp for schedule(static)
    for (int i = levels.begin[level]; i < levels.begin[level + 1]; ++i) eliminate(a, modification, i, factor);
  }
  return factor;
}

void solve(const SlicedFactor& factor, std::span<const Real> r, std::span<Real> z) {
  const SlicedRows &lower = factor.lower, &upper = factor.upper;
  const Array<float>& inverse = factor.inverse;
  const Array<std::int32_t>& first_slice = factor.first_slice;
  const int levels = static_cast<int>(first_slice.size()) - 1;
#pragma omp parallel
  {
    // A slice writes its own rows of z, and reads those of slices of other levels, which the barrier at the end of the
    // loop keeps apart.
    for (int level = 0; level < levels; ++level) {
#pragma omp for schedule(static)
      for (int s = first_slice[level]; s < first_slice[level + 1]; ++s) {
        const int i = lower.first_row[s];
        const maskv rows = first_lanes(lower.first_row[s + 1] - i);
        floatv sum = load(&r[i], rows);
        for (int k = lower.first_slot[s]; k < lower.first_slot[s + 1]; ++k) {
          const auto [active, value, at] = entries(lower, lower.slots[k], z.data());
          where(active, sum) -= value * at;
        }
        store(&z[i], load(&inverse[i], rows) * sum, rows);
      }
    }
    for (int level = levels - 1; level >= 0; --level) {
#pragma omp for schedule(static)
      for (int s = first_slice[level]; s < first_slice[level + 1]; ++s) {
        const int i = upper.first_row[s];
        const maskv rows = first_lanes(upper.first_row[s + 1] - i);
        floatv sum = 0.f;
        for (int k = upper.first_slot[s]; k < upper.first_slot[s + 1]; ++k) {
          const auto [active, value, at] = entries(upper, upper.slots[k], z.data());
          where(active, sum) += value * at;
        }
        store(&z[i], load(&z[i], rows) - load(&inverse[i], rows) * sum, rows);
      }
    }
  }
}

}  // namespace lockstep::linear::openmp
