// Vectors of sixteen particles: those of particles that stand side by side, or one particle's in every lane.
#pragma once

#include "common/fluid/particles.h"
#include "common/simd.h"

namespace lockstep::fluid::openmp {

// Those of particles i .. i + 15.
LOCKSTEP_INLINE Vector3<floatv> lanes_at(const Vectors<float>& vectors, int i) {
  return {load(&vectors.x[i]), load(&vectors.y[i]), load(&vectors.z[i])};
}
LOCKSTEP_INLINE Vector3<floatv> lanes_at(const Vectors<float>& vectors, int i, maskv mask) {
  return {load(&vectors.x[i], mask), load(&vectors.y[i], mask), load(&vectors.z[i], mask)};
}
using fluid::put;
LOCKSTEP_INLINE void put(Vectors<float>& vectors, int i, const Vector3<floatv>& vector, maskv mask) {
  store(&vectors.x[i], vector.x, mask);
  store(&vectors.y[i], vector.y, mask);
  store(&vectors.z[i], vector.z, mask);
}

// That of particle i.
LOCKSTEP_INLINE Vector3<floatv> repeat_at(const Vectors<float>& vectors, int i) {
  return {vectors.x[i], vectors.y[i], vectors.z[i]};
}

LOCKSTEP_INLINE Vector3<float> reduce_add(const Vector3<floatv>& v) {
  return {lockstep::reduce_add(v.x), lockstep::reduce_add(v.y), lockstep::reduce_add(v.z)};
}

}  // namespace lockstep::fluid::openmp
