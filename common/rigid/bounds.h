// Contract: puts colliders where their bodies are, and a box along the world's axes around each, as the broad phase needs them.
//
// The box is the smallest that holds the collider, widened by `margin` on every side, m. A plane's is everything: from -infinity to
// infinity.
//
// In: world.bodies.pose, world.colliders, world.hulls. Out: placed[collider] and bounds, both made to fit.
// Source:  [LRB08] Figure 5, "the bounding volume of each object along its axis".
#pragma once

#include <limits>

#include "common/math.h"
#include "common/rigid/world.h"

namespace lockstep::rigid {

// One box, or sixteen. A box that is empty, from infinity to -infinity, touches none.
template <class T>
struct Box {
  Vector3<T> low, high;
};

// Closed: boxes that touch overlap.
template <class A, class B>
inline auto overlap(const Box<A>& a, const Box<B>& b) {
  return (a.low.x <= b.high.x) & (b.low.x <= a.high.x) & (a.low.y <= b.high.y) & (b.low.y <= a.high.y) & (a.low.z <= b.high.z) &
         (b.low.z <= a.high.z);
}

// The box around two.
template <class T>
inline Box<T> around(const Box<T>& a, const Box<T>& b) {
  return {{min(a.low.x, b.low.x), min(a.low.y, b.low.y), min(a.low.z, b.low.z)},
          {max(a.high.x, b.high.x), max(a.high.y, b.high.y), max(a.high.z, b.high.z)}};
}

template <class Real>
struct Bounds {
  int count = 0;
  Vectors<Real> low, high;  // [collider], m

  void resize(int n) {
    count = n;
    low.resize(n), high.resize(n);
  }
  Box<Real> box(int i) const { return {{low.x[i], low.y[i], low.z[i]}, {high.x[i], high.y[i], high.z[i]}}; }
  void set(int i, const Box<Real>& box) {
    low.x[i] = box.low.x, low.y[i] = box.low.y, low.z[i] = box.low.z;
    high.x[i] = box.high.x, high.y[i] = box.high.y, high.z[i] = box.high.z;
  }
  bool bounded(int i) const { return low.x[i] > -std::numeric_limits<Real>::infinity(); }
};

template <class Real>
inline constexpr Box<Real> empty_box = {
    {std::numeric_limits<Real>::infinity(), std::numeric_limits<Real>::infinity(), std::numeric_limits<Real>::infinity()},
    {-std::numeric_limits<Real>::infinity(), -std::numeric_limits<Real>::infinity(), -std::numeric_limits<Real>::infinity()}};
template <class Real>
inline constexpr Box<Real> whole_space = {empty_box<Real>.high, empty_box<Real>.low};

template <class Real>
using PlaceColliders = void(const World<Real>& world, Real margin, Array<Pose<Real>>& placed, Bounds<Real>& bounds);

namespace serial {
PlaceColliders<float> place_colliders;
PlaceColliders<double> place_colliders;
}  // namespace serial

namespace openmp {
PlaceColliders<float> place_colliders;
}  // namespace openmp

}  // namespace lockstep::rigid
