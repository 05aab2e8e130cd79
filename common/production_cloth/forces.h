// Contract: the elastic forces of a cloth on its vertices, in N, and what damping needs of the cloth's present shape.
//
//   f_v = sum over the links at v, then its membranes, then its folding triangles, each in their order, of their forces
//
// summed from 0, each element's as element_forces.h says. Held vertices feel them, too. Gravity is not among them.
//
//   springs     f = (Y / L) (l - L) u
//   membranes   f = -A P Dm^-T: P = F S, of St. Venant and Kirchhoff; or co-rotated. Plane stress
//   hinges      f_i = k |e|^2 / (|N1| + |N2|) (sin(theta / 2) - sin(theta0 / 2)) u_i, which has no potential
//   quadratic   f = -Q x, Q = sum over hinges of 3 D / (A1 + A2) K K^T, K of cotangents at rest
//
// forces_colours adds up in the order of colours instead, kind by kind.
//
// In:      elements; position, m, finite; colours, made for the elements.
// Out:     force, N; state, of the elements' size, all of it but the padding; of the contrasts only scratch.
// Scratch is in the state. Arrays are padded.
//
// Source: Bridson, Marino and Fedkiw 2003; Bergou et al. 2006; [ITJ07] "Production Cloth".
#pragma once

#include "common/production_cloth/colours.h"
#include "common/production_cloth/elastic.h"
#include "common/production_cloth/element_forces.h"

namespace lockstep::production_cloth {

template <class Real>
using Forces = void(const Elements<Real>& elements, const Vectors<Real>& position, State<Real>& state,
                    Vectors<Real>& force);

template <class Real>
using ForcesInColours = void(const Elements<Real>& elements, const Colours& colours, const Vectors<Real>& position,
                             State<Real>& state, Vectors<Real>& force);

namespace serial {
State<float> make_state(const Elements<float>& elements);
State<double> make_state(const Elements<double>& elements);
Forces<float> forces;
Forces<double> forces;
ForcesInColours<float> forces_colours;
ForcesInColours<double> forces_colours;
}  // namespace serial

namespace openmp {
State<float> make_state(const Elements<float>& elements);
Forces<float> forces;
// Each vertex computes its membranes, and what its triangles' hinges resist with, itself.
Forces<float> forces_recompute;
ForcesInColours<float> forces_colours;
// Each addition under its vertex's lock, in the order in which threads come: rounding depends on it.
Forces<float> forces_locks;
}  // namespace openmp

// --- Formulas; of a number or of lanes. field(array, k) is field k of the one element or of the sixteen.

template <class T, class Real, class Field>
inline Membrane<T> membrane_of(const Elements<Real>& elements, const Field& field) {
  return {field(elements.membrane, 0), field(elements.membrane, 1), field(elements.membrane, 2),
          field(elements.membrane, 3)};
}

template <class T, class Real>
inline Columns<T> stress_of_membrane(const Elements<Real>& elements, const Columns<T>& f) {
  const T lambda(elements.lambda), mu(elements.mu);
  return elements.corotated ? corotated_stress(lambda, mu, f) : stvk_stress(lambda, mu, f);
}

}  // namespace lockstep::production_cloth
