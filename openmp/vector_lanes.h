// Sixteen vectors at once: loaded from three arrays, gathered, and stored. In serial/ the same calls move one vector
// (common/vector3.h).
#pragma once

#include "common/simd.h"
#include "common/vector3.h"

namespace lockstep {

// Local copies of the array pointers: otherwise the compiler must reload them after every store (aliasing).
inline Vector3<float*> pointers(Vectors<float>& v) { return {v.x.data(), v.y.data(), v.z.data()}; }
inline Vector3<const float*> pointers(const Vectors<float>& v) { return {v.x.data(), v.y.data(), v.z.data()}; }

// Vectors i, i + 1, ... i + 15.
LOCKSTEP_INLINE Vector3<floatv> load(const Vector3<const float*>& v, int i) {
  return {load(v.x + i), load(v.y + i), load(v.z + i)};
}
LOCKSTEP_INLINE Vector3<floatv> load(const Vector3<float*>& v, int i) {
  return {load(v.x + i), load(v.y + i), load(v.z + i)};
}
LOCKSTEP_INLINE Vector3<floatv> load(const Vector3<float*>& v, int i, maskv mask) {
  return {load(v.x + i, mask), load(v.y + i, mask), load(v.z + i, mask)};
}
LOCKSTEP_INLINE void store(const Vector3<float*>& v, int i, const Vector3<floatv>& value) {
  store(v.x + i, value.x), store(v.y + i, value.y), store(v.z + i, value.z);
}
LOCKSTEP_INLINE void store(const Vector3<float*>& v, int i, const Vector3<floatv>& value, maskv mask) {
  store(v.x + i, value.x, mask), store(v.y + i, value.y, mask), store(v.z + i, value.z, mask);
}

// Vector i of each lane's own i.
LOCKSTEP_INLINE Vector3<floatv> load(const Vector3<float*>& v, intv i) {
  return {gather(v.x, i), gather(v.y, i), gather(v.z, i)};
}

}  // namespace lockstep
