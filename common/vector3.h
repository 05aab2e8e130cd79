// Three components: of one point (Vector3), and of many, one array a component (Vectors).
#pragma once

#include "common/array.h"

namespace lockstep {

template <class Real>
struct Vector3 {
  Real x, y, z;
};

template <class Real>
struct Vectors {
  Array<Real> x, y, z;

  // Room for n vectors, padded for lanes; what is new is zero.
  void resize(std::size_t n) {
    for (Array<Real>* component : {&x, &y, &z}) component->resize(padded(n));
  }
};

}  // namespace lockstep
