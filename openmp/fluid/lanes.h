// One particle's vector in every lane, and the sum of sixteen vectors.
#pragma once

#include "common/fluid/particles.h"
#include "common/simd.h"

namespace lockstep::fluid::openmp {

// The vector of particle i, in every lane. Arrays: Vectors, or pointers to its components.
template <class Arrays>
LOCKSTEP_INLINE Vector3<floatv> repeat_at(const Arrays& vectors, int i) {
  return {vectors.x[i], vectors.y[i], vectors.z[i]};
}

LOCKSTEP_INLINE Vector3<float> reduce_add(const Vector3<floatv>& v) {
  return {lockstep::reduce_add(v.x), lockstep::reduce_add(v.y), lockstep::reduce_add(v.z)};
}

}  // namespace lockstep::fluid::openmp
