// Elements of a cloth that would meet within a step are stopped by impulses.
//
// In batches or all at once, sixteen at a time (respond_in_order.h).
//
// The contract stands in common/production_cloth/impulses.h.
#include "common/production_cloth/impulses.h"

#include "common/real.h"
#include "openmp/production_cloth/respond_in_order.h"

namespace lockstep::production_cloth::openmp {

void impulses_batches(const Contacts<Real>& impacts, Real friction, const Array<Real>& inverse_mass,
                      Vectors<Real>& velocity) {
  respond_in_batches(impacts, StopGain(), friction, inverse_mass, velocity);
}

void impulses_jacobi(const Contacts<Real>& impacts, Real friction, const Array<Real>& inverse_mass,
                     Vectors<Real>& velocity) {
  respond_at_once(impacts, StopGain(), friction, inverse_mass, velocity);
}

}  // namespace lockstep::production_cloth::openmp
