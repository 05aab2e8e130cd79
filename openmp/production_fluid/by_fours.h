// Values of phi for the closest points of sixteen cells (common/production_fluid/closest_point.h), each with a stencil
// of its own. The four values of a stencil in one line stand side by side, and come by one access. With a gather for
// each value, sweeping with its closest points took a sixth to a quarter more time.
//
// No serial twin: numbers are loaded one by one.
#pragma once

#include <algorithm>

#include "common/simd.h"

namespace lockstep::production_fluid::openmp {

// load_fours(index) loads the values at index and at the three places behind it.
template <class LoadFours>
struct ByFours {
  LoadFours load_fours;
  LOCKSTEP_INLINE floatv operator()(const intv& index) const { return load_fours(index).field[0]; }
};
template <class LoadFours>
ByFours(LoadFours) -> ByFours<LoadFours>;

// Where the box ends inside a lane's stencil, values are chosen from among the four; the last may be padding.
template <class LoadFours>
LOCKSTEP_INLINE void load_row(const ByFours<LoadFours>& load, const intv& line, const intv (&x)[4], floatv (&row)[4]) {
  const auto [four] = load.load_fours(line + x[0]);
  std::copy(four, four + 4, row);
  if (all(x[3] == x[0] + 3)) return;
  for (int a = 1; a < 4; ++a)
    for (int before = 0; before < a; ++before) where(x[a] == x[0] + before, row[a]) = four[before];
}

}  // namespace lockstep::production_fluid::openmp
