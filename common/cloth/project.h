// The projection of a distance constraint, written once: for numbers in serial/, for sixteen lanes in openmp/.
#pragma once

#include "common/math.h"

namespace lockstep::cloth {

// One particle, or sixteen: V is a number, or lanes.
template <class V>
struct Point {
  V x, y, z;
  V w;  // inverse mass
};

// Moves two particles along the line between them towards their rest length, whose square is rest_2, each in proportion
// to its inverse mass.
//
// With d = b - a and rest length L, the exact correction is d (|d| - L) / |d|. This is d (|d|^2 - L^2) / (|d|^2 + L^2),
// equal to first order in |d| - L, without a square root [Jakobsen 2001]. It is too small where the constraint is far
// from satisfied: a link twice too long comes out at .8 L, and coincident particles stay where they are. Nothing moves
// where both are pinned.
template <class V>
[[gnu::always_inline]] inline void project(Point<V>& a, Point<V>& b, V rest_2) {
  const V dx = b.x - a.x, dy = b.y - a.y, dz = b.z - a.z;
  const V d2 = dx * dx + dy * dy + dz * dz;
  const V w = a.w + b.w;
  const V s = select(w > V(0), (d2 - rest_2) / ((d2 + rest_2) * w), V(0));
  const V sa = s * a.w, sb = s * b.w;
  a.x += sa * dx, a.y += sa * dy, a.z += sa * dz;
  b.x -= sb * dx, b.y -= sb * dy, b.z -= sb * dz;
}

}  // namespace lockstep::cloth
