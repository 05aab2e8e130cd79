// The incomplete Cholesky factor and its solve, level by level: rows of a level do not wait for one another, so threads
// share them, and the solve takes sixteen at once. A row reads the same values as in serial order, so the bits are the
// serial ones.
//
// Each level ends with a barrier; a grid of 128^3 points has 382 levels. The matrix is numbered by levels, so what a
// level reads and writes is near what the level before wrote, and columns of a slice mostly stand side by side
// (common/linear/sliced.h).
//
// The contract stands in common/linear/incomplete_cholesky.h.
#include "common/linear/incomplete_cholesky.h"

#include "common/linear/eliminate.h"
#include "common/real.h"
#include "openmp/linear/slots.h"
#include "openmp/whole_vectors.h"

namespace lockstep::linear::openmp {

using lockstep::openmp::with_first_lanes;

Factor<Real> incomplete_cholesky(const Rows<Real>& a, const Levels& levels, Modification modification) {
  Factor<Real> factor = make_factor(a);
#pragma omp parallel
  for (int level = 0; level < levels.count(); ++level) {
    // A row writes its own values, and reads those of rows of earlier levels, which the barrier at the end of this loop
    // has completed.
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
    // A slice writes its own rows of z. The other rows that it reads are of levels that the barrier at the end of each
    // loop has completed.
    for (int level = 0; level < levels; ++level) {
#pragma omp for schedule(static)
      for (int s = first_slice[level]; s < first_slice[level + 1]; ++s) {
        const int i = lower.first_row[s];
        with_first_lanes(lower.first_row[s + 1] - i, [&](auto rows) {
          floatv sum = load(&r[i], rows);
          for (int k = lower.first_slot[s]; k < lower.first_slot[s + 1]; ++k) {
            const auto [active, value, at] = entries(lower, lower.slots[k], z.data(), X::written);
            where(active, sum) -= value * at;
          }
          store(&z[i], load(&inverse[i], rows) * sum, rows);
        });
      }
    }
    for (int level = levels - 1; level >= 0; --level) {
#pragma omp for schedule(static)
      for (int s = first_slice[level]; s < first_slice[level + 1]; ++s) {
        const int i = upper.first_row[s];
        with_first_lanes(upper.first_row[s + 1] - i, [&](auto rows) {
          floatv sum = 0.f;
          for (int k = upper.first_slot[s]; k < upper.first_slot[s + 1]; ++k) {
            const auto [active, value, at] = entries(upper, upper.slots[k], z.data(), X::written);
            where(active, sum) += value * at;
          }
          store(&z[i], load(&z[i], rows) - load(&inverse[i], rows) * sum, rows);
        });
      }
    }
  }
}

}  // namespace lockstep::linear::openmp
