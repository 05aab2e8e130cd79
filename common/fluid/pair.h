// What two particles do to each other: the formulas of the densities and the forces, once for a number and for lanes.
//
// Number is Real, or floatv where Real is float: then each lane is a pair of its own. The bits are the same.
//
// Source: the kernels of [Mueller 2003] with the symmetrised terms of notes/fluid.md.
#pragma once

#include "common/fluid/model.h"

namespace lockstep::fluid {

// What each of two particles adds to the other's density, without model.density_coefficient; r2 = |p_i - p_j|^2 <= h2 =
// h^2, m^2.
template <class Real, class Number>
inline Number density_term(Real h2, Number r2) {
  const Number t = h2 - r2;
  return t * t * t;
}

// The density where these terms sum up to `sum`.
template <class Real>
inline Real density_of(const Model<Real>& model, Real sum) {
  return max(model.least_density, sum * model.density_coefficient);
}

// Factors of a pair: the acceleration of particle i by particle j is pressure (p_i - p_j) + viscosity (v_j - v_i).
template <class Number>
struct PairFactors {
  Number pressure, viscosity;
};

// Densities in kg/m^3; r2 = |p_i - p_j|^2 < h^2. The same bits with i and j exchanged.
template <class Real, class Number>
inline PairFactors<Number> pair_factors(const Model<Real>& model, Number density_i, Number density_j, Number r2) {
  const Number distance = sqrt(max(r2, Number(model.min_distance_2)));
  const Number overlap = model.smoothing_length - distance;
  const Number scale = overlap / (density_i * density_j * distance);  // the one division
  return {model.pressure_coefficient * scale * overlap * (density_i + density_j - model.twice_rest_density),
          model.viscosity_coefficient * scale * distance};
}

// The acceleration of particle i by particle j, m/s^2; dp = p_i - p_j, dv = v_j - v_i. That of j by i is its negative,
// to the bit.
template <class Real, class Number>
inline Vector3<Number> pair_acceleration(const Model<Real>& model, Number density_i, Number density_j,
                                         const Vector3<Number>& dp, const Vector3<Number>& dv, Number r2) {
  const PairFactors<Number> factors = pair_factors(model, density_i, density_j, r2);
  return factors.pressure * dp + factors.viscosity * dv;
}

}  // namespace lockstep::fluid
