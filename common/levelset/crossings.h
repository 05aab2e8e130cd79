// Where the interface crosses the axes beside a point, written once: for numbers in serial/, for sixteen lanes in
// openmp/.
//
// From a point, the interface crosses an axis at theta spacings, as linear interpolation between the point and its
// neighbour has it: 1 / theta = 1 + |phi of the neighbour| / |phi|. So the nearer crossing of an axis is the one
// towards the greater |phi|, and the plane through the crossings is at h / sqrt(sum 1 / theta^2): nothing is divided by
// a small theta.
#pragma once

#include "common/math.h"
#include "common/vector3.h"

namespace lockstep::levelset {

// The greater |phi| of the two neighbours along an axis that are on the other side of the interface, or on it; negative
// where neither is.
template <class V>
[[gnu::always_inline]] inline V other_side(V phi, V before, V after) {
  return select(phi < V(0), max(before, after), max(-before, -after));
}

// Whether a point is beside the interface: phi is 0, or `beyond`, from other_side, is >= 0 along some axis.
template <class V>
[[gnu::always_inline]] inline auto beside_interface(V phi, const Vector3<V>& beyond) {
  return (phi == V(0)) | (max(beyond.x, max(beyond.y, beyond.z)) >= V(0));
}

template <class V>
[[gnu::always_inline]] inline V inverse_theta(V phi, V beyond) {
  return select(beyond >= V(0), V(1) + beyond / abs(phi), V(0));
}

// The distance, in the unit of the spacing, of a point beside the interface from it.
template <class V>
[[gnu::always_inline]] inline V distance_from_crossings(V phi, const Vector3<V>& beyond, V spacing) {
  const V x = inverse_theta(phi, beyond.x), y = inverse_theta(phi, beyond.y), z = inverse_theta(phi, beyond.z);
  return select(phi == V(0), V(0), spacing / sqrt(x * x + y * y + z * z));
}

}  // namespace lockstep::levelset
