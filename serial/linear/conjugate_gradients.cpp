// Conjugate gradients over the serial kernels.
//
// The contract stands in common/linear/conjugate_gradients.h, the loop in common/linear/iterate.h.
#include "common/linear/conjugate_gradients.h"

#include <algorithm>

#include "common/linear/iterate.h"
#include "common/real.h"

namespace lockstep::linear::serial {

Solution conjugate_gradients(const System<Real>& system, std::span<const Real> b, std::span<Real> x, const Stop& stop) {
  const VectorKernels<Real> kernels = {dot, axpy, advance, descend};
  std::ranges::fill(x, Real(0));
  Array<Real> r(b.size()), z(b.size()), p(b.size());
  return iterate(kernels, system, b, {x, r, z, p}, stop);
}

}  // namespace lockstep::linear::serial
