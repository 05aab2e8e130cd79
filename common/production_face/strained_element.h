// One strained tetrahedron and its fibres, as stiffness and products read them. For a number or for lanes.
#pragma once

#include "common/production_face/body.h"
#include "common/production_face/flesh_material.h"

namespace lockstep::production_face {

template <class T>
struct StrainedElement {
  Vector3<T> gradient[3];  // of corners 1, 2 and 3
  T volume;
  Matrix3<T> u, v;
  StressDerivative<T> derivative;
};

template <class T>
struct StrainedFibre {
  Vector3<T> direction, along;  // w and F w
  T per_stretch, stiffness;
};

namespace strained_detail {

template <class T, class Fields>
LOCKSTEP_INLINE Vector3<T> vector_from(const Fields& from, int k) {
  return {from(k), from(k + 1), from(k + 2)};
}
template <class T, class Fields>
LOCKSTEP_INLINE Matrix3<T> matrix_from(const Fields& from) {
  return {vector_from<T>(from, 0), vector_from<T>(from, 3), vector_from<T>(from, 6)};
}

}  // namespace strained_detail

// field(array, k) is field k of `array`, of the one element or of the sixteen that T holds.
template <class T, class Real, class Field>
LOCKSTEP_INLINE StrainedElement<T> strained_element(const Body<Real>& body, const Strained<Real>& strained,
                                                    const Field& field) {
  using namespace strained_detail;
  const auto of = [&](const Blocked<Real>& array) { return [&](int k) { return field(array, k); }; };
  const auto gradient = of(body.gradient), derivative = of(strained.derivative);
  return {{vector_from<T>(gradient, 0), vector_from<T>(gradient, 3), vector_from<T>(gradient, 6)},
          field(body.volume, 0),
          matrix_from<T>(of(strained.u)),
          matrix_from<T>(of(strained.v)),
          {derivative(0), derivative(1), derivative(2), derivative(3), derivative(4), derivative(5),
           vector_from<T>(derivative, 6), vector_from<T>(derivative, 9)}};
}

template <class T, class Real, class Field>
LOCKSTEP_INLINE StrainedFibre<T> strained_fibre(const Body<Real>& body, const Strained<Real>& strained,
                                                const Field& field) {
  using namespace strained_detail;
  const auto of = [&](const Blocked<Real>& array) { return [&](int k) { return field(array, k); }; };
  return {vector_from<T>(of(body.fibre), 0), vector_from<T>(of(strained.pull), 0), field(strained.pull, 3),
          field(strained.pull, 4)};
}

}  // namespace lockstep::production_face
