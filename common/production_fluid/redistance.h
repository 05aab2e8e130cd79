// Contract: the level set becomes the signed distance from its own surface again.
//
//   phi = -d where phi < 0, else d
//
// Beside the surface, d = |phi| / |grad phi| where phi is nearly a distance, 1/2 <= |grad phi| <= 2, by differences with
// the cells on both sides. Elsewhere d is the distance that levelset/ finds from the crossings of phi
// (common/levelset/initialize.h), which is too large where the surface is oblique: with it in all cells the liquid
// shrinks (notes/production_fluid.md). The other cells get the distance that levelset/ computes from these, as far as
// `band`, and `band` beyond. So the surface stays where phi crosses 0, to first order.
//
//   sweeping   by one round of fast sweeping. In a narrow band one round leaves rounding (notes/levelset.md).
//   marching   by fast marching in blocks.
//
// In, out: phi, finite. Padding is not changed.
// In:      band, m, > 0.
// Scratch: distances; any content, which afterwards is unspecified.
// Source:  [ITJ07] "Production Fluid", Figures 6 to 8. PhysBAM, too, goes from the crossings to the surface along phi's
//          slope.
#pragma once

#include "common/levelset/field.h"
#include "common/math.h"
#include "common/production_fluid/state.h"
#include "common/vector3.h"

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

// --- Formulas; of numbers or of lanes

// |grad phi| at a cell, by differences with its neighbours; at a side of the box with the one that is there. load(index)
// is an element of phi, counted from cell (0, 0, 0).
template <class Index, class Real, class Load>
inline auto steepness(const Field<Real>& phi, const Index& x, const Index& y, const Index& z, const Load& load) {
  const Index here = (z * Index(phi.ny) + y) * Index(phi.pitch) + x;
  using Number = decltype(load(here));
  const auto rise = [&](const Index& at, int n, int step) {
    const auto low = at > Index(0), high = at < Index(n - 1);
    const Number difference =
        load(here + select(high, Index(step), Index(0))) - load(here - select(low, Index(step), Index(0)));
    return select(low & high, Number(.5f), Number(1)) * difference;
  };
  const Vector3<Number> slope = {rise(x, phi.nx, 1), rise(y, phi.ny, phi.pitch), rise(z, phi.nz, phi.pitch * phi.ny)};
  return sqrt(dot(slope, slope)) / Number(phi.spacing);
}

// The distance of a cell beside the surface.
template <class Number>
inline Number refined_distance(const Number& phi, const Number& steepness, const Number& from_crossings) {
  const auto nearly = (steepness >= Number(.5f)) & (steepness <= Number(2));
  return select(nearly, abs(phi) / select(nearly, steepness, Number(1)), from_crossings);
}

template <class Number>
inline Number signed_distance(const Number& phi, const Number& distance, const Number& band) {
  const Number d = min(distance, band);
  return select(phi < Number(0), Number(0) - d, d);
}

}  // namespace lockstep::production_fluid
