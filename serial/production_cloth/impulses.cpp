// Elements of a cloth that would meet within a step are stopped by impulses.
//
// What repulsions leave, continuous collision detection finds: elements that meet at a time within the step. Each of
// these impacts gets the impulse after which its two points move alike along the normal, so that they do not meet.
//
// The contract stands in common/production_cloth/impulses.h.
#include "common/production_cloth/impulses.h"

#include "common/real.h"
#include "serial/production_cloth/respond_in_order.h"

namespace lockstep::production_cloth::serial {

void impulses_original(const Contacts<Real>& impacts, Real friction, const Array<Real>& inverse_mass,
                       Vectors<Real>& velocity) {
  respond_in_order(impacts, StopGain(), friction, inverse_mass, velocity);
}

void impulses_batches(const Contacts<Real>& impacts, Real friction, const Array<Real>& inverse_mass,
                      Vectors<Real>& velocity) {
  respond_in_batches(impacts, StopGain(), friction, inverse_mass, velocity);
}

void impulses_jacobi(const Contacts<Real>& impacts, Real friction, const Array<Real>& inverse_mass,
                     Vectors<Real>& velocity) {
  respond_at_once(impacts, StopGain(), friction, inverse_mass, velocity);
}

}  // namespace lockstep::production_cloth::serial
