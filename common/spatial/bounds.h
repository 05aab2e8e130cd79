// Boxes along the world's axes: one, sixteen, or an array of them.
#pragma once

#include <limits>

#include "common/math.h"
#include "common/vector3.h"

namespace lockstep::spatial {

// One box (T a number) or sixteen (T floatv). An empty box, from infinity to -infinity, overlaps no box.
template <class T>
struct Box {
  Vector3<T> low, high;
};

// Boxes are closed: boxes that touch overlap.
template <class A, class B>
inline auto overlap(const Box<A>& a, const Box<B>& b) {
  return (a.low.x <= b.high.x) & (b.low.x <= a.high.x) & (a.low.y <= b.high.y) & (b.low.y <= a.high.y) &
         (a.low.z <= b.high.z) & (b.low.z <= a.high.z);
}

// The smallest box around two.
template <class T>
inline Box<T> around(const Box<T>& a, const Box<T>& b) {
  return {{min(a.low.x, b.low.x), min(a.low.y, b.low.y), min(a.low.z, b.low.z)},
          {max(a.high.x, b.high.x), max(a.high.y, b.high.y), max(a.high.z, b.high.z)}};
}

// Boxes 0 .. count - 1, m, padded for lanes.
template <class Real>
struct Bounds {
  int count = 0;
  Vectors<Real> low, high;

  void resize(int n) {
    count = n;
    low.resize(n), high.resize(n);
  }
  Box<Real> box(int i) const { return {{low.x[i], low.y[i], low.z[i]}, {high.x[i], high.y[i], high.z[i]}}; }
  void set(int i, const Box<Real>& box) {
    low.x[i] = box.low.x, low.y[i] = box.low.y, low.z[i] = box.low.z;
    high.x[i] = box.high.x, high.y[i] = box.high.y, high.z[i] = box.high.z;
  }
  // An element without bounds, such as a plane, has the box whole_space.
  bool bounded(int i) const { return low.x[i] > -std::numeric_limits<Real>::infinity(); }
};

template <class Real>
inline constexpr Box<Real> empty_box = {{std::numeric_limits<Real>::infinity(), std::numeric_limits<Real>::infinity(),
                                         std::numeric_limits<Real>::infinity()},
                                        {-std::numeric_limits<Real>::infinity(), -std::numeric_limits<Real>::infinity(),
                                         -std::numeric_limits<Real>::infinity()}};
template <class Real>
inline constexpr Box<Real> whole_space = {empty_box<Real>.high, empty_box<Real>.low};

}  // namespace lockstep::spatial
