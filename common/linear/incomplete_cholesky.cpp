#include "common/linear/incomplete_cholesky.h"

namespace lockstep::linear {

SlicedFactor slice(const Factor<float>& factor, const Levels& levels) {
  SlicedFactor sliced{.lower = slice(factor.lower, levels.begin),
                      .upper = slice(factor.upper, levels.begin),
                      .inverse = factor.inverse,
                      .first_slice = {}};
  int s = 0;
  for (const std::int32_t row : levels.begin) {
    while (sliced.lower.first_row[s] != row) ++s;
    sliced.first_slice.push_back(s);
  }
  return sliced;
}

}  // namespace lockstep::linear
