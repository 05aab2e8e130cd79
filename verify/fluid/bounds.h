// Rounding bounds of the game fluid's sums, as notes/fluid.md derives them. All in double, from the widened float
// state.
#pragma once

#include <span>
#include <vector>

#include "common/fluid/fluid.h"

namespace lockstep::verify {

// For each particle: how far the float densities of two correct implementations may lie apart by the order of their
// sums, n u density with n the number of terms.
std::vector<double> density_rounding(const fluid::Fluid<double>& truth, std::span<const double> density);

// For each particle and axis, m/s^2: the same of accelerations, n u sum |terms|, where densities are given to
// within density_error (kg/m^3, of each particle; zero where both implementations are given the same).
Vectors<double> force_rounding(const fluid::Fluid<double>& truth, std::span<const double> density,
                               std::span<const double> density_error);

// The density of a particle inside a simple cubic lattice: the analytic sum.
double lattice_density(const fluid::Model<double>& model, double spacing);

// How far the density of one of a lattice's particles may lie from that: by the rounding of positions up to `reach`
// from the origin and of the sum.
double lattice_density_rounding(const fluid::Model<double>& model, double spacing, double reach);

}  // namespace lockstep::verify
