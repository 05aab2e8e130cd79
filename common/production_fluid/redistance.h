// Contract: the level set becomes the signed distance from its own surface again.
//
//   phi = -d where phi < 0, else d
//
// d is the distance that levelset/ computes from the crossings of phi (common/levelset/initialize.h), as far as `band`;
// d = band at all cells farther away. So the surface stays where phi crosses 0, to first order.
//
//   sweeping   by one round of fast sweeping. In a narrow band one round leaves rounding (notes/levelset.md).
//   marching   by fast marching in blocks.
//
// In, out: phi, finite. Padding is not changed.
// In:      band, m, > 0.
// Scratch: distances; any content, which afterwards is unspecified.
// Source:  [ITJ07] "Production Fluid", Figures 6 to 8.
#pragma once

#include "common/levelset/field.h"
#include "common/math.h"
#include "common/production_fluid/state.h"

namespace lockstep::production_fluid {

using levelset::Distances;

template <class Real>
using Redistance = void(Field<Real>& phi, Real band, Distances<Real>& distances);

namespace serial {
Redistance<float> redistance_sweeping, redistance_marching;
Redistance<double> redistance_sweeping, redistance_marching;
}  // namespace serial

namespace openmp {
Redistance<float> redistance_sweeping, redistance_marching;
}  // namespace openmp

// How far the step redistances, in cells: where nothing moves by more than a cell, phi is still known 3 cells from the
// surface after a step.
inline constexpr float band_of_level_set = 4;

// Of a number or of lanes.
template <class Number>
inline Number signed_distance(const Number& phi, const Number& distance, const Number& band) {
  const Number d = min(distance, band);
  return select(phi < Number(0), Number(0) - d, d);
}

}  // namespace lockstep::production_fluid
