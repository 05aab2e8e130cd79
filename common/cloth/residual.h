// How far a cloth is from satisfying its constraints.
#pragma once

#include <cmath>

#include "common/cloth/cloth.h"

namespace lockstep::cloth {

// The root mean square of the strain |d| / L - 1 over all constraints. Computed in double.
template <class Real>
double residual(const Cloth<Real>& cloth) {
  const Constraints<Real>& list = cloth.constraints;
  const Vectors<Real>& p = cloth.position;
  double sum = 0;
  for (int k = 0; k < list.count; ++k) {
    const int a = list.a[k], b = list.b[k];
    const double dx = double(p.x[b]) - p.x[a], dy = double(p.y[b]) - p.y[a], dz = double(p.z[b]) - p.z[a];
    const double strain = std::sqrt((dx * dx + dy * dy + dz * dz) / list.rest_2[k]) - 1;
    sum += strain * strain;
  }
  return list.count > 0 ? std::sqrt(sum / list.count) : 0;
}

}  // namespace lockstep::cloth
