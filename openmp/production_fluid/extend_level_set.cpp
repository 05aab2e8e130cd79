// Carries the level set on into obstacles, level by level. Cells of a level do not read one another, so threads share
// them out, sixteen at a time.
//
// The contract stands in common/production_fluid/extend_level_set.h.
#include "common/production_fluid/extend_level_set.h"

#include <algorithm>

#include "common/real.h"
#include "common/simd.h"

namespace lockstep::production_fluid::openmp {

void extend_level_set(const Extension<Real>& extension, Field<Real>& phi) {
  const Array<std::int32_t>& first = extension.first;
  const int levels = static_cast<int>(first.size()) - 1;
  if (levels == 0) return;
  Real* const value = phi.value.data();
#pragma omp parallel
  for (int level = 0; level < levels; ++level) {
    const int end = first[level + 1];
    // A cell is one iteration's, and reads cells of earlier levels, which the barrier at the loop's end has completed.
#pragma omp for schedule(static)
    for (int k = first[level]; k < end; k += lanes) {
      const maskv there = first_lanes(end - k);
      const auto neighbour = [&](int axis) { return gather(value, load(&extension.neighbour[axis][k]), there); };
      const floatv around[] = {neighbour(0), neighbour(1), neighbour(2)};
      const auto share = [&](int axis) { return load(&extension.share[axis][k]); };
      alignas(64) Real made[lanes];
      store(made, mean_of_neighbours(around, {share(0), share(1), share(2)}));
      for (int lane = 0; lane < std::min(lanes, end - k); ++lane) value[extension.cell[k + lane]] = made[lane];
    }
  }
}

}  // namespace lockstep::production_fluid::openmp
